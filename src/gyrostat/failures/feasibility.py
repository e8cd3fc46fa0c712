"""Feasible rest attitudes of a spacecraft with failed wheels: query and answer."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.failures.certificate import (
    NOTHING,
    Certificate,
    certificate_at,
    certificate_for_ever,
    longest_dwell,
)
from gyrostat.failures.controllability import is_controllable
from gyrostat.failures.momentum_envelope import TOLERANCE
from gyrostat.failures.nearest_attitude import (
    Rest,
    certificate_of_roll,
    momentum_at,
    nearest_attitude,
    nearest_direction,
)
from gyrostat.failures.query import Case, unit_vector, vector
from gyrostat.failures.sky_map import EDGE, SkyMap, sky_map
from gyrostat.spacecraft import Spacecraft

UNIT_TOLERANCE = 1e-3
"""Of the length of a target quaternion: what was typed with four digits is meant as unit."""


@dataclass(frozen=True)
class Holdable:
    """What can be held after a failure.

    Attributes:
        holdable: whether the target can be held at rest; for a boresight, at some roll.
        rank: how many directions the axes of the working wheels span.
        reason: why nothing can be held; None where something can.
        dimension: of the set of holdable attitudes, 0 to 3; None where it is empty. A turn about
            the total momentum is always free, so with momentum it is at least 1.
        angle: from the target to the nearest holdable attitude, or from the wanted direction to the
            nearest one that the boresight can hold, rad; None where nothing can be held.
        attitude: (4,) the nearest holdable attitude, and where the roll is free the one with the
            most margin; None likewise.
        direction: (3,) inertial unit vector to which the boresight points there; None without
            boresight.
        momentum_in_body: (3,) total momentum in body axes there, N·m·s.
        wheel_momentum: (wheels,) of every wheel there, failed ones too, N·m·s.
        margin: what is left there of the limit of the most loaded wheel, as a share; 1 without
            limits.
        controllable: whether the working wheels control the attitude about there, to first order.
        at_target: certificate of the rate at the target; zero where it is holdable. For a boresight
            that of the roll with the least rate, found by search over the roll.
        for_ever: certificate of the rate at every attitude; zero where some can be held.
        dwell: upper bound of the time that the attitude can stay within the tolerance of the
            target, s; None where there is no bound or no tolerance was given.
        sky: the map of a boresight; None without one.
    """

    holdable: bool
    rank: int
    reason: str | None = None
    dimension: int | None = None
    angle: float | None = None
    attitude: Vector | None = None
    direction: Vector | None = None
    momentum_in_body: Vector | None = None
    wheel_momentum: Vector | None = None
    margin: float | None = None
    controllable: bool | None = None
    at_target: Certificate = NOTHING
    for_ever: Certificate = NOTHING
    dwell: float | None = None
    sky: SkyMap | None = None

    @property
    def empty(self) -> bool:
        """Whether no attitude at all can be held."""
        return self.reason is not None

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers and lists, SI units and radians."""
        return _plain(asdict(self))


def holdable(
    spacecraft: Spacecraft,
    momentum: ArrayLike,
    *,
    failed: Mapping[int, float],
    target: ArrayLike | None = None,
    boresight: tuple[ArrayLike, ArrayLike] | None = None,
    tolerance: float | None = None,
) -> Holdable:
    """Say what a spacecraft can hold at rest with some of its wheels failed.

    The total momentum H0 = R (J w + W h) is conserved. At rest the wheels carry all of it:
    with b = R'H0 and the momentum p of the failed wheels, b - p = W_A h, each h_i within its limit.
    All attitudes with the same b differ by a turn about H0, and the one nearest to a target with
    b_t is as far from it as b from b_t. The nearest b is found exactly, from a finite list.

    Args:
        spacecraft: one, no batch. Torque from outside is left out, and the momentum of a wheel is
            meant along its axis in inertial space: its rotor's share of a body rate is left out.
        momentum: (3,) total, inertial axes, N·m·s.
        failed: number of each failed wheel -> the momentum that it keeps, N·m·s: 0 where it is
            seized or has run down.
        target: (4,) attitude to hold, or
        boresight: direction in the body and inertial direction to point it at, (3,) each, with any
            roll.
        tolerance: of pointing at a target attitude, rad, for the dwell time; below pi/2.

    Raises:
        InputError: a spacecraft, a wheel or a number that is none; no target, or two.
    """
    case = Case.of(spacecraft, momentum, failed)
    if tolerance is not None and not 0.0 < tolerance < 0.5 * np.pi:
        raise InputError(f"tolerance: found {tolerance:g}, expected rad between 0 and pi/2")
    if (target is None) == (boresight is None):
        found = "none" if target is None else "both"
        raise InputError(f"target and boresight: found {found}, expected one of them")
    if boresight is not None:
        if tolerance is not None:
            raise InputError(
                "tolerance: found one for a boresight, expected it with a target: a body that may "
                "roll about its boresight may keep it pointed for any time"
            )
        body, inertial = (
            unit_vector(value, 3, name)
            for value, name in zip(boresight, ("boresight", "direction to point at"), strict=True)
        )
        return _for_boresight(case, body, inertial)
    quaternion = vector(target, 4, "target", "")
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise InputError(f"target: found a quaternion of length {length:g}, expected 1")
    return _for_attitude(case, quaternion / length, tolerance)


def holdable_sky(
    spacecraft: Spacecraft,
    momentum: ArrayLike,
    *,
    failed: Mapping[int, float],
    boresight: ArrayLike,
) -> SkyMap:
    """The inertial directions that a boresight can hold; arguments as for `holdable`.

    Args:
        spacecraft: one, no batch.
        momentum: (3,) total, inertial axes, N·m·s.
        failed: number of each failed wheel -> its momentum, N·m·s.
        boresight: (3,) direction in the body.

    Raises:
        InputError: a spacecraft, a wheel or a number that is none.
    """
    case = Case.of(spacecraft, momentum, failed)
    return sky_map(case.held, case.momentum, case.radius, unit_vector(boresight, 3, "boresight"))


def _for_attitude(case: Case, target: Vector, tolerance: float | None) -> Holdable:
    rest = nearest_attitude(case, target)
    if rest is not None and rest.angle <= EDGE:
        return _answer(case, rest)
    wanted = momentum_at(case, target)
    certificate = certificate_at(case.held, case.inertia, wanted)
    dwell = None
    if tolerance is not None:
        limits = case.torque_limits
        dwell = longest_dwell(case.held, case.inertia, wanted, certificate, limits, tolerance)
    return _answer(case, rest, at_target=certificate, dwell=dwell)


def _for_boresight(case: Case, body: Vector, wanted: Vector) -> Holdable:
    sky = sky_map(case.held, case.momentum, case.radius, body)
    rest = nearest_direction(case, body, wanted)
    if rest is not None and rest.angle <= EDGE:
        return _answer(case, rest, sky=sky)
    return _answer(case, rest, at_target=certificate_of_roll(case, body, wanted), sky=sky)


def _answer(
    case: Case,
    rest: Rest | None,
    *,
    at_target: Certificate = NOTHING,
    dwell: float | None = None,
    sky: SkyMap | None = None,
) -> Holdable:
    """The answer with what follows from a holdable attitude, or from there being none."""
    held = case.held
    if rest is None:
        return Holdable(
            holdable=False,
            reason=_reason(case),
            rank=held.rank,
            at_target=at_target,
            for_ever=certificate_for_ever(held, case.inertia, case.radius),
            dwell=dwell,
            sky=sky,
        )
    return Holdable(
        holdable=rest.angle <= EDGE,
        rank=held.rank,
        dimension=_dimension(case),
        angle=rest.angle,
        attitude=rest.attitude,
        direction=rest.direction,
        momentum_in_body=rest.momentum,
        wheel_momentum=case.all_wheels(held.wheel_momentum(rest.momentum)),
        margin=1.0 - float(held.load(rest.momentum)),
        controllable=is_controllable(case.inertia, held.axes, held.rank, rest.momentum),
        at_target=at_target,
        dwell=dwell,
        sky=sky,
    )


def _dimension(case: Case) -> int:
    """A sphere that enters the set cuts it across; one that touches it meets single points."""
    if not case.radius:
        return 3
    slack = TOLERANCE * (case.radius + float(np.linalg.norm(case.held.frozen)))
    crosses = case.held.least + slack < case.radius < case.held.most - slack
    return max(case.held.rank - 1, 0) + 1 if crosses else 1


def _reason(case: Case) -> str:
    there = f"the total momentum is {case.radius:.6g} N·m·s"
    if case.held.most < case.radius:
        return f"{there}, and the wheels hold at most {case.held.most:.6g} N·m·s"
    return f"the wheels hold at least {case.held.least:.6g} N·m·s, and {there}"


def _plain(value: Any) -> Any:
    """Arrays as lists, all the way down."""
    if isinstance(value, dict):
        return {name: _plain(entry) for name, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value
