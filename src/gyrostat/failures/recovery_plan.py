"""Choose the target attitude and the controller after wheel failures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.control import MomentumRecovery, OneWheelRecovery, ZeroMomentumRecovery
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.types import Vector
from gyrostat.core.validation import require
from gyrostat.failures import Holdable, holdable
from gyrostat.spacecraft import Spacecraft

LEAST_ACROSS = 0.1
"""N·m·s: momentum across the normal of two working wheels above which it controls the attitude."""
NOTHING_HELD = 1e-9
"""N·m·s: below it a failed wheel holds nothing."""


@dataclass(frozen=True)
class Loss:
    """How a wheel failed.

    Attributes:
        kind: "frozen": without torque, keeping its momentum but for its own friction; "seized":
            stopped at once; "rundown": without torque, running down.
        time_constant: of running down, s.
    """

    kind: Literal["frozen", "seized", "rundown"]
    time_constant: float = 60.0

    def __post_init__(self) -> None:
        """Refuse what is no loss.

        Raises:
            InputError: another kind, or a time constant that is not above zero.
        """
        if self.kind not in ("frozen", "seized", "rundown"):
            raise InputError(
                f"failure of a wheel: found {self.kind!r}, expected frozen, seized or rundown"
            )
        require("time constant of running down", self.time_constant, "s", positive=True)


@dataclass(frozen=True)
class RecoveryPlan:
    """What to do after a failure.

    Attributes:
        answer: what can be held, and the nearest attitude: the one to aim at.
        controller: for the loop; None where none gets there.
        reason: why there is none; empty where there is one.
    """

    answer: Holdable
    controller: Any
    reason: str


def plan_recovery(
    spacecraft: Spacecraft,
    momentum: ArrayLike,
    *,
    failed: Mapping[int, float],
    target: ArrayLike,
    seized: frozenset[int] | set[int] = frozenset(),
) -> RecoveryPlan:
    """Choose attitude and controller.

    Three directions left: a three-axis law. Two, and momentum across their normal: the law that
    turns the spacecraft about the normal by that momentum. Two and next to none: sweeps from rest
    to rest. One, where it controls the attitude: the law that damps by energy.

    Args:
        spacecraft: as the controller shall know it.
        momentum: (3,) total, inertial axes, N·m·s.
        failed: number of each failed wheel -> the momentum that it will keep, N·m·s.
        target: (4,) attitude wanted, scalar first.
        seized: numbers of the failed wheels whose rotor is fixed to the body.

    Raises:
        InputError: see `gyrostat.failures.holdable`.
    """
    answer = holdable(spacecraft, momentum, failed=failed, target=target)
    working = np.array([k not in failed for k in range(spacecraft.wheels.count)])
    if answer.attitude is None or answer.momentum_in_body is None:
        return RecoveryPlan(answer, None, f"nothing can be held: {answer.reason}")
    if answer.rank == 0:
        return RecoveryPlan(answer, None, "no wheel works")
    fixed = np.array([k in seized for k in range(spacecraft.wheels.count)])
    known = {"total_momentum": momentum, "target": answer.attitude, "seized": fixed}
    if answer.rank == 1:
        try:
            return RecoveryPlan(answer, OneWheelRecovery.plan(spacecraft, working, **known), "")
        except InputError as error:
            return RecoveryPlan(answer, None, f"out of reach for one wheel: {error}")
    if answer.rank == 3 or _across(spacecraft, working, answer.momentum_in_body) >= LEAST_ACROSS:
        return RecoveryPlan(answer, MomentumRecovery.plan(spacecraft, working, **known), "")
    if max(map(abs, failed.values()), default=0.0) > NOTHING_HELD:
        return RecoveryPlan(
            answer,
            None,
            f"less than {LEAST_ACROSS:g} N·m·s across the normal of the working wheels, and a "
            "failed wheel that still turns: no law for both",
        )
    controller = ZeroMomentumRecovery.plan(spacecraft, working, target=jnp.asarray(answer.attitude))
    return RecoveryPlan(answer, controller, "")


def _across(spacecraft: Spacecraft, working: np.ndarray, momentum: Vector) -> float:
    """Part of a momentum in body axes in the plane of two directions of working axes, N·m·s."""
    axes = np.asarray(spacecraft.wheels.axes) * working
    normal = np.linalg.svd(axes)[0][:, 2]
    return float(np.linalg.norm(np.cross(normal, momentum)))
