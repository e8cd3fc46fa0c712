"""Choice of the target attitude and the controller after wheel failures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.control import MomentumRecovery, OneWheelRecovery, ZeroMomentumRecovery
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.core.validation import require
from gyrostat.failures.feasibility import Holdable, holdable
from gyrostat.spacecraft import Spacecraft

LEAST_ACROSS = 0.1
"""Momentum in the plane of two working wheels, N·m·s, above which it allows attitude control."""
NOTHING_HELD = 1e-9
"""Momentum below which a failed wheel counts as stopped, N·m·s."""


@dataclass(frozen=True)
class Loss(Described):
    """Failure of a wheel.

    Attributes:
        kind: "frozen": no torque, momentum constant except for the wheel's own friction; "seized":
            stopped at once; "rundown": no torque, speed decays exponentially.
        time_constant: Time constant of the decay, s.
        brake_time: Time constant with which the short-circuited motor slows the wheel down, s:
            rotor inertia times winding resistance over the square of the motor constant. None
            without a short circuit.
        brake_torque: Torque with which the motor can still brake, N·m; 0 if it cannot.
    """

    kind: Literal["frozen", "seized", "rundown"]
    time_constant: float = 60.0
    brake_time: float | None = None
    brake_torque: float = 0.0

    @property
    def decay_rate(self) -> float:
        """Rate of the exponential decay of the wheel speed, 1/s; 0 if there is none."""
        rate = 1.0 / self.time_constant if self.kind == "rundown" else 0.0
        return rate + (0.0 if self.brake_time is None else 1.0 / self.brake_time)

    @property
    def is_braked(self) -> bool:
        """Whether the motor or a short circuit slows the wheel down."""
        return self.brake_time is not None or self.brake_torque > 0.0

    @property
    def slows_down(self) -> bool:
        """Whether the wheel runs down or is braked, and ends at rest."""
        return self.kind == "rundown" or self.is_braked

    def __post_init__(self) -> None:
        """Validate parameters.

        Raises:
            InputError: An unknown kind, a time constant that is not above zero, a negative brake
                torque, or a brake on a seized wheel.
        """
        if self.kind not in ("frozen", "seized", "rundown"):
            raise InputError(
                f"failure of a wheel: found {self.kind!r}, expected frozen, seized or rundown"
            )
        require("time constant of running down", self.time_constant, "s", positive=True)
        if self.brake_time is not None:
            require("time constant of the brake", self.brake_time, "s", positive=True)
        require("brake torque", self.brake_torque, "N·m")
        if self.kind == "seized" and self.is_braked:
            raise InputError("brake: found a seized wheel, expected a wheel that still turns")


@dataclass(frozen=True)
class RecoveryPlan(Described):
    """Target attitude and controller after a failure.

    Attributes:
        answer: Feasibility answer; its nearest feasible attitude is the target.
        controller: Controller for the simulation; None if none can reach the target.
        reason: Reason why there is no controller; empty if there is one.
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
    """Choose target attitude and controller.

    The choice depends on the rank of the working wheels' axes. Rank 3: three-axis control. Rank 2
    with momentum in the plane of the working wheels: the law that uses this momentum to rotate the
    spacecraft about the normal of that plane. Rank 2 with almost no momentum in that plane: a
    sequence of rest-to-rest manoeuvres. Rank 1, if it controls the attitude: energy damping.

    Args:
        spacecraft: Model of the spacecraft that the controller uses.
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        failed: Index of each failed wheel -> the momentum that it will keep, N·m·s.
        target: Wanted attitude, (4,), scalar first.
        seized: Indices of the failed wheels whose rotor is fixed to the body.

    Raises:
        InputError: An input is invalid; see `gyrostat.failures.holdable`.
    """
    answer = holdable(spacecraft, momentum, failed=failed, target=target)
    working = np.array([k not in failed for k in range(spacecraft.wheels.count)])
    if answer.attitude is None or answer.momentum_in_body is None:
        return RecoveryPlan(answer, None, f"no attitude is feasible: {answer.reason}")
    if answer.rank == 0:
        return RecoveryPlan(answer, None, "no wheel works")
    fixed = np.array([k in seized for k in range(spacecraft.wheels.count)])
    options = {"total_momentum": momentum, "target": answer.attitude, "seized": fixed}
    if answer.rank == 1:
        try:
            return RecoveryPlan(answer, OneWheelRecovery.plan(spacecraft, working, **options), "")
        except InputError as error:
            return RecoveryPlan(answer, None, f"out of reach for one wheel: {error}")
    if answer.rank == 3 or across(spacecraft, working, answer.momentum_in_body) >= LEAST_ACROSS:
        return RecoveryPlan(answer, MomentumRecovery.plan(spacecraft, working, **options), "")
    if max(map(abs, failed.values()), default=0.0) > NOTHING_HELD:
        return RecoveryPlan(
            answer,
            None,
            f"less than {LEAST_ACROSS:g} N·m·s across the normal of the working wheels, and a "
            "failed wheel that still turns: no controller handles both",
        )
    controller = ZeroMomentumRecovery.plan(spacecraft, working, target=jnp.asarray(answer.attitude))
    return RecoveryPlan(answer, controller, "")


def plane_normal(spacecraft: Spacecraft, working: np.ndarray) -> Vector:
    """Direction that the axes of the working wheels span least, body axes, (3,).

    Args:
        spacecraft: Spacecraft.
        working: Whether each wheel works, (wheels,).
    """
    return np.linalg.svd(np.asarray(spacecraft.wheels.axes) * working)[0][:, 2]


def across(spacecraft: Spacecraft, working: np.ndarray, momentum: Vector) -> float:
    """Magnitude of a momentum's projection on the plane of the working axes, N·m·s.

    Args:
        spacecraft: Spacecraft.
        working: Whether each wheel works, (wheels,).
        momentum: Momentum, body axes, (3,), N·m·s.
    """
    return float(np.linalg.norm(np.cross(plane_normal(spacecraft, working), momentum)))
