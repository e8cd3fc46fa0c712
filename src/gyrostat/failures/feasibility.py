"""Feasible rest attitudes of a spacecraft with failed wheels: query and answer."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import PicturedText
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
from gyrostat.failures.query import Case, unit_quaternion, unit_vector
from gyrostat.failures.sky_map import EDGE, SkyMap, sky_map
from gyrostat.failures.unloading import unload_at, unload_for_boresight
from gyrostat.spacecraft import Spacecraft


@dataclass(frozen=True)
class Holdable(PicturedText):
    """Answer to a feasibility query.

    Attributes:
        holdable: Whether the target can be held at rest; for a boresight, at some roll angle.
        rank: Dimension of the span of the working wheels' axes.
        reason: Reason why no attitude can be held; None if some attitude can.
        dimension: Dimension of the set of feasible attitudes, 0 to 3; None if it is empty. Rotation
            about the total momentum is always free, so that it is at least 1 if there is momentum.
        angle: Angle from the target to the nearest feasible attitude, or from the wanted direction
            to the nearest one at which the boresight can be held, rad; None if no attitude is
            feasible.
        attitude: Nearest feasible attitude, (4,); if the roll is free, the one with the largest
            margin; None if no attitude is feasible.
        direction: Inertial unit vector along the boresight at that attitude, (3,); None without a
            boresight.
        momentum_in_body: Total momentum in body axes at that attitude, (3,), N·m·s.
        wheel_momentum: Momentum of every wheel at that attitude, including failed ones, (wheels,),
            N·m·s.
        margin: Unused fraction of the momentum limit of the most loaded wheel at that attitude; 1
            without limits.
        controllable: Whether the working wheels control the attitude near that attitude, to first
            order.
        at_target: Certificate at the target; zero if the target is feasible. For a boresight, the
            certificate at the roll angle with the lowest bound, found by a search over the roll.
        for_ever: Certificate for all attitudes; zero if some attitude is feasible.
        dwell: Upper bound of the time that the attitude can stay within the tolerance of the
            target, s; None if there is no bound or no tolerance was given.
        sky: Sky map of the boresight; None without a boresight.
        unload: Momentum to remove from the spacecraft so that the target becomes feasible, the
            smallest one, inertial axes, (3,), N·m·s; None if the target is feasible.
        question: What `gyrostat.feasible` was asked, for text and picture; None of other answers.
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
    unload: Vector | None = None
    question: Any = field(default=None, repr=False, compare=False)

    @property
    def empty(self) -> bool:
        """Whether no attitude can be held."""
        return self.reason is not None

    def to_dict(self) -> dict[str, Any]:
        """Convert to plain numbers and lists, SI units and radians."""
        content = asdict(replace(self, question=None))
        del content["question"]
        return _as_lists(content)


def holdable(
    spacecraft: Spacecraft,
    momentum: ArrayLike,
    *,
    failed: Mapping[int, float],
    target: ArrayLike | None = None,
    boresight: tuple[ArrayLike, ArrayLike] | None = None,
    tolerance: float | None = None,
) -> Holdable:
    """Find the attitudes that a spacecraft with failed wheels can hold at rest.

    The total momentum H0 = R (J w + W h) is conserved. At rest the wheels carry all of it: with b =
    R'H0 and the momentum p of the failed wheels, b - p = W_A h, each h_i within its limit. All
    attitudes with the same b differ by a rotation about H0. The distance from a target with b_t to
    the nearest of them is the angle between b and b_t. The nearest b is found exactly, from a
    finite list.

    Args:
        spacecraft: A single spacecraft, not a batch. External torque is neglected. The momentum of
            a wheel is taken along its axis without the contribution of the body rate.
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        failed: Index of each failed wheel -> the momentum that it keeps, N·m·s; 0 if it is seized
            or has run down.
        target: Attitude to hold, (4,); give either this or `boresight`.
        boresight: Direction in the body, and the inertial direction to point it at, (3,) each. The
            roll angle is free.
        tolerance: Pointing tolerance at a target attitude, rad, for the dwell time; below pi/2.

    Raises:
        InputError: An invalid spacecraft, wheel index or number; no target, or two.
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
            unit_vector(value, name)
            for value, name in zip(boresight, ("boresight", "direction to point at"), strict=True)
        )
        return _for_boresight(case, body, inertial)
    return _for_attitude(case, unit_quaternion(target, "target"), tolerance)


def holdable_sky(
    spacecraft: Spacecraft,
    momentum: ArrayLike,
    *,
    failed: Mapping[int, float],
    boresight: ArrayLike,
) -> SkyMap:
    """Find the inertial directions at which a boresight can be held.

    Args:
        spacecraft: A single spacecraft, not a batch.
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        failed: Index of each failed wheel -> its momentum, N·m·s.
        boresight: Direction in the body, (3,).

    Raises:
        InputError: An invalid spacecraft, wheel index or number.
    """
    case = Case.of(spacecraft, momentum, failed)
    return sky_map(case.held, case.momentum, case.radius, unit_vector(boresight, "boresight"))


def _for_attitude(case: Case, target: Vector, tolerance: float | None) -> Holdable:
    rest = nearest_attitude(case, target)
    if rest is not None and rest.angle <= EDGE:
        return _answer(case, rest)
    momentum = momentum_at(case, target)
    certificate = certificate_at(case.held, case.inertia, momentum)
    dwell = None
    if tolerance is not None:
        limits = case.torque_limits
        dwell = longest_dwell(case.held, case.inertia, momentum, certificate, limits, tolerance)
    unload = unload_at(case, target)
    return _answer(case, rest, at_target=certificate, dwell=dwell, unload=unload)


def _for_boresight(case: Case, body: Vector, direction: Vector) -> Holdable:
    sky = sky_map(case.held, case.momentum, case.radius, body)
    rest = nearest_direction(case, body, direction)
    if rest is not None and rest.angle <= EDGE:
        return _answer(case, rest, sky=sky)
    certificate = certificate_of_roll(case, body, direction)
    unload = unload_for_boresight(case, body, direction)
    return _answer(case, rest, at_target=certificate, sky=sky, unload=unload)


def _answer(case: Case, rest: Rest | None, **fields: Any) -> Holdable:
    """Answer of a query.

    Args:
        case: Validated inputs.
        rest: Feasible attitude that is nearest to the wanted one; None if there is none.
        fields: Further fields of the answer.
    """
    envelope = case.held
    if rest is None:
        return Holdable(
            holdable=False,
            reason=reason_of(case),
            rank=envelope.rank,
            for_ever=certificate_for_ever(envelope, case.inertia, case.radius),
            **fields,
        )
    return Holdable(
        holdable=rest.angle <= EDGE,
        rank=envelope.rank,
        dimension=_dimension(case),
        angle=rest.angle,
        attitude=rest.attitude,
        direction=rest.direction,
        momentum_in_body=rest.momentum,
        wheel_momentum=case.all_wheels(envelope.wheel_momentum(rest.momentum)),
        margin=1.0 - float(envelope.load(rest.momentum)),
        controllable=is_controllable(case.inertia, envelope.axes, envelope.rank, rest.momentum),
        **fields,
    )


def _dimension(case: Case) -> int:
    """Dimension of the feasible set; a sphere that only touches the envelope meets it in points."""
    if not case.radius:
        return 3
    slack = TOLERANCE * (case.radius + float(np.linalg.norm(case.held.frozen)))
    crosses = case.held.least + slack < case.radius < case.held.most - slack
    return max(case.held.rank - 1, 0) + 1 if crosses else 1


def reason_of(case: Case) -> str:
    """Reason why no attitude is feasible."""
    total = f"the total momentum is {case.radius:.6g} N·m·s"
    if case.held.most < case.radius:
        return f"{total}, and the wheels hold at most {case.held.most:.6g} N·m·s"
    return f"the wheels hold at least {case.held.least:.6g} N·m·s, and {total}"


def _as_lists(value: Any) -> Any:
    """Convert arrays to lists, recursively."""
    if isinstance(value, dict):
        return {name: _as_lists(entry) for name, entry in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    return value
