"""Plan of one slew of a scenario around keep-out cones."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gyrostat.control.guidance import (
    Profile,
    SlewLimits,
    SlewProfile,
    Transition,
    Turn,
    plan_slew,
)
from gyrostat.control.guidance.keep_out_slew import SAMPLES, PlannedSlew
from gyrostat.control.guidance.planned_turns import turned_beside
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.slew_cones import SlewCones, slew_cones
from gyrostat.scenario.reference_kind import AROUND
from gyrostat.spacecraft.sensors.keep_out import KeepOut

TIMES = 129
"""Times at which the bodies are evaluated for a slew."""
ATTEMPTS = 8
"""Largest number of plans of a slew, each for a longer motion of the bodies than the one before."""
ALIGNED = np.array([1.0, 0.0, 0.0, 0.0])
"""Attitude of the target in its own axes."""


class SlewToPlan(NamedTuple):
    """Slew around cones before its plan.

    Attributes:
        place: Place of the mode or slew in the scenario.
        origin: Name of what is before it.
        instruments: Names of the instruments that it leads around.
        eigenaxis: Transition without a plan.
        target: Attitude over time after it.
        start: Time at which it starts, or the first one at which it may, s.
        last: Last time at which it may start, s; that of `start` if it is known.
        spread: Largest change of its rotation while it may start, rad.
    """

    place: str
    origin: str
    instruments: tuple[str, ...]
    eigenaxis: Transition
    target: Profile
    start: float
    last: float
    spread: float = 0.0


class SlewPlanner(NamedTuple):
    """What the slews of a scenario are planned with.

    Attributes:
        limits: Limits of the slews.
        keep_outs: Name -> each instrument.
        margin: Angle that they keep beside that of the instruments, rad.
        crossing_time: Time that a slew may lose to avoid a zero crossing, s.
    """

    limits: SlewLimits
    keep_outs: Mapping[str, KeepOut]
    margin: float
    crossing_time: float

    def plan(self, slew: SlewToPlan) -> tuple[Turn, tuple[float, float]]:
        """Plan a slew in axes of its target.

        In them the bodies move: each cone contains its body at all times of the slew. It is wider
        by the angle by which the transition turns the body beside the path, because the motion
        before it has a rate and an acceleration relative to the target.

        Args:
            slew: Slew.

        Returns:
            The plan, and what its cones are widened for, see `PlannedTurns.covers`.

        Raises:
            InputError: An end is inside a cone, or no clear path within the limits is found.
        """
        before = slew.eigenaxis
        rate, gain = (float(np.linalg.norm(x)) for x in (before.rate, before.acceleration))
        offset = rotations.from_rotation_vector(before.turn)
        crossing = self.crossing_time if self.crossing_time > 0.0 else None
        limits, time = self._limits_at(slew), 1.05 * float(before.duration)
        for _ in range(ATTEMPTS):
            beside = turned_beside(rate, gain, time)
            covers = self.margin + slew.spread, float(beside)
            wider = sum(covers)
            times = np.linspace(slew.start, slew.last + time, TIMES)
            cones = slew_cones(self.keep_outs, slew.instruments, slew.target, times, wider)
            found = plan_slew(offset, ALIGNED, cones.cones, limits, slew.start, crossing)
            _check_found(slew, found, cones, (offset, jnp.asarray(ALIGNED)))
            profile = _with_change(found, rate)
            if profile.duration <= time:
                bows = jnp.stack([found.path.bow, found.path.twist])
                return jax.tree.map(np.asarray, Turn(found.path.turn, bows, profile)), covers
            time = 1.1 * float(profile.duration)
        raise InputError(
            f"key {slew.place}.{AROUND}: found a slew from {slew.origin} during which the bodies "
            "move ever farther, expected a faster slew or a slower target"
        )

    def _limits_at(self, slew: SlewToPlan) -> SlewLimits:
        """Limits with the total momentum in axes of the target."""
        envelope = self.limits.envelope
        if envelope is None:
            return self.limits
        attitude = rotations.normalised(jnp.asarray(slew.target(slew.start), dtype=float))
        total = rotations.to_body(attitude, jnp.asarray(envelope.total_momentum))
        return replace(self.limits, envelope=replace(envelope, total_momentum=total))


def _with_change(found: PlannedSlew, rate: float) -> SlewProfile:
    """Profile that lasts long enough for a change of the rate, see `SlewLimits.profile`."""
    profile = found.profile
    size = np.max(np.linalg.norm(found.path.sampled(SAMPLES[1]).rate, axis=-1))
    largest = max(float(profile.acceleration) * float(size), 1e-12)
    longer = np.sqrt(1.0 + (4.0 * rate / largest / max(float(profile.duration), 1e-12)) ** 2)
    times = (longer * each for each in (profile.ramp, profile.hold, profile.cruise))
    return SlewProfile(profile.angle, profile.acceleration / longer**2, *times)


def _check_found(
    slew: SlewToPlan, found: PlannedSlew, cones: SlewCones, ends: tuple[Any, Any]
) -> None:
    """Check that a slew is clear and that its wheels have room; raises `InputError`."""
    if found.is_clear and found.has_room:
        return
    place = f"key {slew.place}.{AROUND}: found"
    when = f"{slew.start:g} s" if slew.last == slew.start else "any time"
    wider = f"with a margin of {np.degrees(cones.wider):.2g} deg and a motion of"
    wider += f" {np.degrees(cones.motion):.2g} deg"
    for name, attitude in zip(("start", "end"), ends, strict=True):
        clearance = np.asarray(cones.cones.clearance(jnp.asarray(attitude)))
        clearance = np.where(np.asarray(cones.cones.angles) > 0.0, clearance, np.inf)
        worst = int(np.argmin(clearance))
        if clearance[worst] < 0.0:
            raise InputError(
                f"{place} the {name} of the slew from {slew.origin} at {when} by "
                f"{-np.degrees(clearance[worst]):.2g} deg too near for {cones.names[worst]}, "
                f"{wider}; expected both ends outside"
            )
    if not found.is_clear:
        names = [n for n, a in zip(cones.names, cones.cones.angles, strict=True) if a > 0.0]
        raise InputError(
            f"{place} no way for the slew from {slew.origin} at {when} around "
            f"{', '.join(names)}, {wider}; expected a mode or slew between, or smaller angles"
        )
    raise InputError(
        f"{place} wheels that hold too much momentum for the slew from {slew.origin} at {when}, "
        "expected less momentum at the start or a larger momentum_share"
    )
