"""Simulation of a recovery after wheel failures."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error_angle
from gyrostat.failures.recovery_plan import Loss, RecoveryPlan, plan_recovery
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import Gyrostat, GyrostatState, Spacecraft, SpacecraftSensor, WheelFailures

if TYPE_CHECKING:
    import xarray as xr

ANGLE, RATE = np.radians(0.05), 1e-4
"""Error, rad, and body rate, rad/s: settled if both stay below these values."""


@dataclass(frozen=True)
class Recovery:
    """Simulated recovery.

    Attributes:
        plan: Target attitude and controller.
        flight: Histories of the run, with `error`, the angle to the target attitude, rad; None if
            no controller can reach the target.
        settle: Time from the failure until the error and rate stay below `ANGLE` and `RATE`, s;
            None if they do not.
        reason: Reason why the spacecraft did not settle; empty if it did.
    """

    plan: RecoveryPlan
    flight: "xr.Dataset | None"
    settle: float | None
    reason: str

    def to_dict(self) -> dict[str, Any]:
        """Convert everything except the histories to plain numbers, SI units and radians."""
        return {
            "settled": self.settle is not None,
            "settle": self.settle,
            "reason": self.reason or None,
            "law": None if self.plan.controller is None else type(self.plan.controller).__name__,
            "holdable": self.plan.answer.to_dict(),
        }


def recover(
    spacecraft: Spacecraft,
    start: GyrostatState,
    losses: Mapping[int, Loss],
    *,
    target: ArrayLike,
    duration: float = 600.0,
    control_period: float = 0.5,
    known: Spacecraft | None = None,
) -> Recovery:
    """Simulate a spacecraft from the failure of wheels to the nearest feasible attitude.

    Args:
        spacecraft: True spacecraft.
        start: State of the spacecraft when the wheels fail.
        losses: Index of each failing wheel -> its failure.
        target: Wanted attitude, (4,), scalar first.
        duration: Duration, s, a whole number of control periods.
        control_period: Control period, s.
        known: Model of the spacecraft that the controller uses; None: the true spacecraft.

    Raises:
        InputError: An invalid spacecraft, wheel index or time.
    """
    spacecraft.check()
    Gyrostat(spacecraft).check_state(start)
    count = spacecraft.wheels.count
    failures, kept = WheelFailures.none(count), {}
    inertia = np.broadcast_to(np.asarray(spacecraft.wheels.inertia), (count,))
    rate = Gyrostat(spacecraft).rate(start)
    for wheel, loss in losses.items():
        if wheel not in range(count):
            raise InputError(f"failed wheel: found {wheel}, expected 0 to {count - 1}")
        kept[wheel] = 0.0
        if loss.kind == "seized":
            failures = failures.seizes(wheel, 0.0)
            continue
        drag = inertia[wheel] / loss.time_constant if loss.kind == "rundown" else 0.0
        failures = failures.torque_lost(wheel, 0.0, added_viscous=drag)
        if loss.kind == "frozen":
            axis = np.asarray(spacecraft.wheels.axes)[:, wheel]
            kept[wheel] = float(inertia[wheel] * (start.wheel_speed[wheel] + axis @ rate))
    plan = plan_recovery(
        known or spacecraft,
        start.momentum,
        failed=kept,
        target=target,
        seized={wheel for wheel, loss in losses.items() if loss.kind == "seized"},
    )
    if plan.controller is None or plan.answer.attitude is None:
        return Recovery(plan, None, None, plan.reason)
    plant = Gyrostat(spacecraft, failures)
    flight = simulate(
        plant,
        plan.controller,
        SpacecraftSensor(plant),
        start=start,
        duration=duration,
        control_period=control_period,
    )
    aim = jnp.asarray(plan.answer.attitude)
    errors = jax.vmap(error_angle, in_axes=(0, None))(jnp.asarray(flight.attitude.values), aim)
    about = {"units": "rad", "long_name": "angle to the feasible attitude"}
    flight["error"] = ("time", np.asarray(errors), about)
    settle = settling_time(flight)
    reason = "" if settle is not None else _why_not(flight)
    return Recovery(plan, flight, settle, reason)


def settling_time(flight: "xr.Dataset") -> float | None:
    """Time after which error and body rate stay small to the end of a run, s, or None."""
    rate = np.linalg.norm(flight.rate.values, axis=1)
    out = ~((flight.error.values < ANGLE) & (rate < RATE))
    if out[-1]:
        return None
    return float(flight.time.values[len(out) - np.argmax(out[::-1]) if out.any() else 0])


def _why_not(flight: "xr.Dataset") -> str:
    until = float(flight.valid_until)
    if int(flight.status) == Status.UNRESOLVED:
        return f"the run ended at {until:g} s: a control period was too long to resolve the motion"
    if int(flight.status) != Status.COMPLETE:
        return f"the run ended at {until:g} s: the body rate is above the limit of the simulation"
    left = float(np.degrees(flight.error.values[-1]))
    return f"not settled at the end, {until:g} s: {left:.3g} deg from the target attitude"
