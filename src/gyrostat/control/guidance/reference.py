"""Reference of one or several modes, which follow each other by conditions."""

from collections.abc import Callable
from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from gyrostat.control.guidance.attitude_reference import (
    AttitudeReference,
    Profile,
    reference_at,
)
from gyrostat.control.guidance.slew import SlewLimits, Transition
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft


class Mode(NamedTuple):
    """Active mode of a reference.

    Attributes:
        number: Number of the mode, from 0.
        start: Time at which it started, s.
    """

    number: Int[Array, ""]
    start: Scalar


class Condition(NamedTuple):
    """Conditions under which a mode ends: all of them must hold. The defaults always hold.

    Attributes:
        after: Least time since the start of the mode, s.
        rate_below: Upper limit of the body rate, rad/s.
        momentum_above: Lower limit of the total momentum, N·m·s.
        error_below: Upper limit of the pointing error, rad.
    """

    after: Scalar = 0.0
    rate_below: Scalar = np.inf
    momentum_above: Scalar = -1.0
    error_below: Scalar = np.inf


NEVER = Condition(after=np.inf)
"""Condition that never holds."""


class Reference(Checked):
    """Reference attitude of one or several modes.

    Each mode has its own attitude over time. From mode to mode, the reference turns by a
    `Transition` within the slew limits. A mode ends when its transition is complete and all of its
    conditions hold; then the next mode starts. The last mode never ends. The conditions use the
    measurement of the sample at which they are tested.

    Attributes:
        modes: Attitude over time of each mode, a `Profile`.
        until: Conditions under which the modes end, each (modes,).
        limits: Limits of the rotation from mode to mode; None for one mode.
        spacecraft: Spacecraft model for the total momentum; None: no condition on it.
    """

    modes: tuple[Callable[..., Any], ...]
    until: Condition
    limits: SlewLimits | None = None
    spacecraft: Spacecraft | None = None

    @classmethod
    def of(cls, profile: Profile) -> Self:
        """Reference of one mode.

        Args:
            profile: Attitude over time.
        """
        return cls.sequence((profile, NEVER))

    @classmethod
    def sequence(
        cls,
        *modes: tuple[Profile, Condition],
        limits: SlewLimits | None = None,
        spacecraft: Spacecraft | None = None,
    ) -> Self:
        """Reference of several modes.

        Args:
            modes: Attitude over time and end conditions of each mode.
            limits: Limits of the rotation from mode to mode; required for several modes.
            spacecraft: Spacecraft model; required for conditions on the momentum.

        Raises:
            InputError: There is no mode, or `limits` or `spacecraft` is required and None.
        """
        if not modes:
            raise InputError("reference: found no mode, expected one or more")
        ends = [condition for _, condition in modes]
        if limits is None and len(modes) > 1:
            raise InputError(
                f"reference of {len(modes)} modes: found no slew limits, expected limits for the "
                "rotation from mode to mode"
            )
        if spacecraft is None and any(end.momentum_above >= 0.0 for end in ends):
            raise InputError(
                "reference: found a condition on the momentum and no spacecraft, expected the "
                "spacecraft from which the momentum is computed"
            )
        until = Condition(*(jnp.asarray(each, dtype=float) for each in zip(*ends, strict=True)))
        return cls(tuple(profile for profile, _ in modes), until, limits, spacecraft)

    def start(self) -> Mode:
        """Mode before the first sample: the first mode, from time 0."""
        return Mode(jnp.zeros((), dtype=int), jnp.zeros(()))

    def bound(self, mode: Mode) -> "BoundReference":
        """Reference in a mode, as a function of time.

        Args:
            mode: Active mode.
        """
        if self.limits is None:
            return BoundReference(self.modes[0])
        return BoundReference(Transition.of(self._motions(mode), mode.start, self.limits))

    def at(self, mode: Mode, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time.

        Args:
            mode: Active mode.
            time: Time, s.
        """
        return self.bound(mode)(time)

    def step(self, mode: Mode, measurement: Any, time: Scalar) -> Mode:
        """Mode that is active from a sample on.

        Args:
            mode: Mode before the sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), rad/s; None for a missing sample, at which only modes end whose
                conditions need no measurement.
            time: Time of the sample, s.
        """
        if self.limits is None:
            return mode
        found = Transition.of(self._motions(mode), mode.start, self.limits)
        until = Condition(*(jnp.asarray(each)[mode.number] for each in self.until))
        # multiples of a control period are subject to rounding
        elapsed = time - mode.start + 1e-9
        ends = (elapsed >= until.after) & (elapsed >= found.duration)
        ends &= mode.number < len(self.modes) - 1
        if measurement is None:
            ends &= jnp.isinf(until.rate_below) & jnp.isinf(until.error_below)
            ends &= until.momentum_above < 0.0
        else:
            ends &= self._measured(until, measurement, rotations.normalised(found(time)))
        return Mode(mode.number + ends, jnp.where(ends, time, mode.start))

    def _measured(self, until: Condition, measurement: Any, target: Quaternion) -> Bool[Array, ""]:
        """Whether the conditions of a mode on the measurement hold."""
        rate = measurement.rate
        holds = rate @ rate < until.rate_below**2
        holds &= rotations.error_angle(measurement.attitude, target) < until.error_below
        if self.spacecraft is None:
            return holds
        wheels = self.spacecraft.wheels
        spun = jnp.asarray(wheels.axes) @ (wheels.inertia * measurement.wheel_speed)
        momentum = self.spacecraft.inertia_locked() @ rate + spun
        return holds & (jnp.sqrt(momentum @ momentum) > until.momentum_above)

    def _motions(self, mode: Mode) -> Callable[[Scalar], Float[Array, "2 4"]]:
        """Attitudes over time of the mode before and of the mode itself."""
        rows = jnp.stack([jnp.maximum(mode.number - 1, 0), mode.number])

        def motions(time: Scalar) -> Float[Array, "2 4"]:
            every = jnp.stack([jnp.asarray(mode(time), dtype=float) for mode in self.modes])
            return jax.vmap(rotations.normalised)(every[rows])

        return motions


class BoundReference(eqx.Module):
    """Reference in one mode: a function of time, for controllers with a field `reference`.

    Attributes:
        motion: Attitude over time.
    """

    motion: Profile

    def __call__(self, time: Scalar) -> AttitudeReference:
        """Attitude, rate and acceleration at a time, s, if the mode does not end before."""
        return reference_at(self.motion, time)
