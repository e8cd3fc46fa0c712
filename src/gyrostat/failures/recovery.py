"""Simulate a recovery after wheel failures."""

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
"""rad and rad/s: below both, for good, the spacecraft has settled."""


@dataclass(frozen=True)
class Recovery:
    """A recovery as it was flown.

    Attributes:
        plan: what was aimed at, and by which controller.
        flight: histories, with `error`, the angle to that attitude, rad; None where no controller
            gets there.
        settle: time from the failure until the spacecraft stays within `ANGLE` and `RATE`, s; None
            where it does not.
        reason: why it did not; empty where it did.
    """

    plan: RecoveryPlan
    flight: "xr.Dataset | None"
    settle: float | None
    reason: str

    def to_dict(self) -> dict[str, Any]:
        """Everything but the histories as plain numbers, SI units and radians."""
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
    """Fly a spacecraft from the moment at which wheels fail to the nearest attitude it can hold.

    Args:
        spacecraft: as it is.
        start: its state when the wheels fail.
        losses: number of each wheel that fails -> how.
        target: (4,) attitude wanted, scalar first.
        duration: s, a whole number of control periods.
        control_period: s.
        known: as the controller knows the spacecraft; None: as it is.

    Raises:
        InputError: a spacecraft, wheel or time that is none.
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
    """Time from which the error and the body rate of a run stay small to its end, s, or None."""
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
        return f"the run ended at {until:g} s: the spacecraft turned too fast for any law"
    left = float(np.degrees(flight.error.values[-1]))
    return f"not settled at the end, {until:g} s: {left:.3g} deg from the attitude aimed at"
