"""Simulation of a recovery after wheel failures."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control import MomentumRecovery
from gyrostat.core.arrays import Quaternion, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.core.pictured import PicturedText
from gyrostat.core.rotations import error_angle
from gyrostat.core.stored_trees import stored_tree_function
from gyrostat.core.types import Vector
from gyrostat.failures.braking import BrakeGain, earliest_settling, with_brakes, without_brakes
from gyrostat.failures.feasibility import Holdable, holdable
from gyrostat.failures.momentum_drift import (
    MomentumDrift,
    feasible_attitudes,
    momentum_drift,
    rates_of,
)
from gyrostat.failures.query import vector
from gyrostat.failures.recovery_plan import Loss, RecoveryPlan, plan_recovery
from gyrostat.simulation import Status
from gyrostat.simulation.labelled import Labelled, Signal
from gyrostat.simulation.simulation import simulated
from gyrostat.spacecraft import Gyrostat, GyrostatState, Spacecraft, SpacecraftSensor, WheelFailures

if TYPE_CHECKING:
    import xarray as xr

ANGLE, RATE = np.radians(0.05), 1e-4
"""Error, rad, and body rate, rad/s: settled if both stay below these values."""
MOMENTUM_TIME = 20.0
"""Time constant of the momentum estimate under an external torque, s."""


@dataclass(frozen=True)
class Recovery(PicturedText):
    """Simulated recovery.

    Attributes:
        plan: Target attitude and controller.
        histories: Histories of the run, with `error`, the angle to the target attitude, rad; None
            if no controller can reach the target.
        settle: Time from the failure until the error and rate stay below `ANGLE` and `RATE`, s;
            None if they do not.
        reason: Reason why the spacecraft did not settle; empty if it did.
        earliest: Index of each failed wheel that loses its momentum -> time after the failure, s,
            before which no controller settles; see `gyrostat.failures.earliest_settling`.
        without_brakes: The same recovery with no wheel braked; None if none is.
        gains: Index of each failed wheel that turns and is not braked -> what braking it with the
            torque limit of its motor would bring. Empty without such a limit.
        drift: Drift of the feasible attitude; None without external torque. With it, `error` is the
            angle to the attitude that is feasible at the momentum of each sample, and settled means
            a rate at most `RATE` above that of this attitude.
        case: Spacecraft file and losses that `gyrostat.recover` was given, for the text; None of
            other recoveries.
    """

    plan: RecoveryPlan
    histories: Labelled | None
    settle: float | None
    reason: str
    earliest: Mapping[int, float] = field(default_factory=dict)
    without_brakes: "Recovery | None" = None
    gains: Mapping[int, BrakeGain] = field(default_factory=dict)
    drift: MomentumDrift | None = None
    case: Any = field(default=None, repr=False, compare=False)

    @property
    def is_too_short(self) -> bool:
        """Whether the run is valid to its end, but the spacecraft had not settled there."""
        if self.histories is None or self.settle is not None:
            return False
        return int(self.histories.variables["status"].values) == Status.COMPLETE

    @cached_property
    def flight(self) -> "xr.Dataset | None":
        """The histories as a dataset of xarray."""
        return None if self.histories is None else self.histories.dataset()

    def to_dict(self, names: Sequence[str] | None = None) -> dict[str, Any]:
        """Convert everything except the histories to plain numbers, SI units and radians.

        Args:
            names: Names of the wheels; None: their indices.
        """
        unbraked = self.without_brakes

        def by_name(values: Mapping[int, Any]) -> dict[str, Any]:
            return {names[k] if names else str(k): value for k, value in values.items()}

        return {
            "settled": self.settle is not None,
            "settle": self.settle,
            "reason": self.reason or None,
            "law": None if self.plan.controller is None else type(self.plan.controller).__name__,
            "holdable": self.plan.answer.to_dict(),
            "earliest": by_name(self.earliest),
            "gains": by_name({wheel: asdict(gain) for wheel, gain in self.gains.items()}),
            "external_torque": None if self.drift is None else asdict(self.drift),
            "without_brakes": None if unbraked is None else unbraked.to_dict(names),
        }


def state_of(
    spacecraft: Spacecraft, attitude: Vector, rate: Vector, wheel_speed: Vector
) -> GyrostatState:
    """State of a spacecraft, by a stored program; see `gyrostat.spacecraft.Gyrostat.start`.

    Args:
        spacecraft: Spacecraft.
        attitude: Attitude quaternion, (4,), scalar first; it is normalised.
        rate: Body rate in body axes, (3,), rad/s.
        wheel_speed: Wheel speeds relative to the body, (wheels,), rad/s.
    """
    return _start(_as_data(spacecraft), attitude, rate, wheel_speed)


def _as_data(spacecraft: Spacecraft) -> Spacecraft:
    """Spacecraft without Python numbers, each of which would be part of a program."""
    return jax.tree.map(np.asarray, spacecraft)


@stored_tree_function
def _start(spacecraft: Spacecraft, attitude: Any, rate: Any, wheel_speed: Any) -> GyrostatState:
    return Gyrostat(spacecraft).start(attitude=attitude, rate=rate, wheel_speed=wheel_speed)


@stored_tree_function
def _rate(spacecraft: Spacecraft, state: GyrostatState) -> Vector3:
    return Gyrostat(spacecraft).rate(state)


@stored_tree_function
def _errors(attitudes: Float[Array, "samples 4"], target: Quaternion) -> Any:
    """Angles between attitudes and the target, (samples,), rad."""
    return jax.vmap(error_angle, in_axes=(0, None))(attitudes, target)


@stored_tree_function
def _errors_to_each(
    attitudes: Float[Array, "samples 4"], targets: Float[Array, "samples 4"]
) -> Any:
    """Angles between attitudes and their targets, (samples,), rad."""
    return jax.vmap(error_angle)(attitudes, targets)


def recover(
    spacecraft: Spacecraft,
    start: GyrostatState,
    losses: Mapping[int, Loss],
    *,
    target: ArrayLike,
    duration: float = 600.0,
    control_period: float = 0.5,
    known: Spacecraft | None = None,
    external_torque: ArrayLike = (0.0, 0.0, 0.0),
) -> Recovery:
    """Simulate a spacecraft from the failure of wheels to the nearest feasible attitude.

    A wheel that is braked ends at rest. The same recovery without brakes is simulated too.

    Args:
        spacecraft: True spacecraft.
        start: State of the spacecraft when the wheels fail.
        losses: Index of each failing wheel -> its failure.
        target: Wanted attitude, (4,), scalar first.
        duration: Duration, s, a whole number of control periods.
        control_period: Control period, s.
        known: Model of the spacecraft that the controller uses; None: the true spacecraft.
        external_torque: Constant external torque, body axes, (3,), N·m.

    Raises:
        InputError: An invalid spacecraft, wheel index or time.
    """
    spacecraft.check()
    Gyrostat(spacecraft).check_state(start)
    count, model = spacecraft.wheels.count, known or spacecraft
    failures, wheel_momenta = WheelFailures.none(count), {}
    inertia = np.broadcast_to(np.asarray(spacecraft.wheels.inertia), (count,))
    rate = np.asarray(_rate(_as_data(spacecraft), start))
    axes = np.asarray(spacecraft.wheels.axes)
    momentum = inertia * (np.asarray(start.wheel_speed) + rate @ axes)
    for wheel, loss in losses.items():
        if wheel not in range(count):
            raise InputError(f"failed wheel: found {wheel}, expected 0 to {count - 1}")
        wheel_momenta[wheel] = 0.0
        if loss.kind == "seized":
            failures = failures.seizes(wheel, 0.0)
            continue
        drag = inertia[wheel] * loss.decay_rate
        failures = failures.torque_lost(wheel, 0.0, added_viscous=drag)
        if not loss.slows_down:
            wheel_momenta[wheel] = float(momentum[wheel])
    plan = plan_recovery(
        model,
        start.momentum,
        failed=wheel_momenta,
        target=target,
        seized={wheel for wheel, loss in losses.items() if loss.kind == "seized"},
    )
    working = np.array([wheel not in losses for wheel in range(count)])
    limits = np.broadcast_to(np.asarray(spacecraft.wheels.torque_limit), (count,))

    def settles(answer: Holdable, wheel: int, loss: Loss) -> float | None:
        return earliest_settling(
            *(spacecraft, answer, working, wheel), momentum=momentum[wheel], loss=loss, error=ANGLE
        )

    earliest, gains = {}, {}
    for wheel, loss in losses.items():
        time = settles(plan.answer, wheel, loss)
        if time is not None:
            earliest[wheel] = time
        if loss.kind != "seized" and not loss.is_braked and np.isfinite(limits[wheel]):
            torque, stopped_momenta = float(limits[wheel]), {**wheel_momenta, wheel: 0.0}
            feasibility = holdable(model, start.momentum, failed=stopped_momenta, target=target)
            time = settles(feasibility, wheel, replace(loss, brake_torque=torque))
            gains[wheel] = BrakeGain(torque, feasibility.angle, time)
    torque: Any = vector(external_torque, 3, "external torque", "N·m")
    plant = Gyrostat(with_brakes(spacecraft, losses), failures, external_torque=torque)
    drift = momentum_drift(
        spacecraft, np.asarray(start.momentum), wheel_momenta, plan.answer, torque, duration
    )
    timing: Any = {"duration": duration, "control_period": control_period}
    alternative = None
    if any(loss.is_braked for loss in losses.values()):
        unbraked = without_brakes(losses)
        options = {"known": known, "external_torque": torque, **timing}
        alternative = recover(spacecraft, start, unbraked, target=target, **options)
    if plan.controller is None or plan.answer.attitude is None:
        return Recovery(plan, None, None, plan.reason, earliest, alternative, gains, drift)
    controller = plan.controller
    if drift is not None and isinstance(controller, MomentumRecovery):
        controller = replace(controller, momentum_time=MOMENTUM_TIME)
    timing |= {"start": start, "stored": True}
    histories = simulated(plant, controller, SpacecraftSensor(plant), **timing)
    attitudes, aim = histories.variables["attitude"].values, plan.answer.attitude
    turning: Any = 0.0
    if drift is None:
        errors = np.asarray(_errors(attitudes, aim))
    else:
        momenta = np.asarray(histories.variables["momentum"].values)
        feasible = feasible_attitudes(spacecraft, momenta, wheel_momenta, aim)
        turning = rates_of(feasible, control_period)
        errors = np.asarray(_errors_to_each(attitudes, feasible))
    about = {"units": "rad", "long_name": "angle to the feasible attitude"}
    error = Signal(("time",), errors, about)
    histories = replace(histories, variables={**histories.variables, "error": error})
    settle = settling_time(histories.arrays(), turning)
    reason = "" if settle is not None else _failure_reason(histories.arrays())
    return Recovery(plan, histories, settle, reason, earliest, alternative, gains, drift)


def settling_time(flight: Mapping[Any, Any], turning: Any = 0.0) -> float | None:
    """Time after which error and body rate stay small to the end of a run, s, or None.

    Args:
        flight: Histories of the run: name -> array, or what can be converted to one.
        turning: Rate at which the feasible attitude turns, (samples,) or one value, rad/s.
    """
    rate = np.linalg.norm(np.asarray(flight["rate"]), axis=1)
    outside = ~((np.asarray(flight["error"]) < ANGLE) & (rate < RATE + turning))
    if outside[-1]:
        return None
    return float(flight["time"][len(outside) - np.argmax(outside[::-1]) if outside.any() else 0])


def _failure_reason(flight: Mapping[str, Any]) -> str:
    until, status = float(flight["valid_until"]), int(flight["status"])
    if status == Status.UNRESOLVED:
        return f"the run ended at {until:g} s: a control period was too long to resolve the motion"
    if status != Status.COMPLETE:
        return f"the run ended at {until:g} s: the body rate is above the limit of the simulation"
    error = float(np.degrees(flight["error"][-1]))
    if np.isnan(error):
        return f"no attitude is feasible at the end, {until:g} s: the total momentum has changed"
    return f"not settled at the end, {until:g} s: {error:.3g} deg from the target attitude"
