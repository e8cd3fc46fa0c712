"""Controllers that a scenario can name, one entry each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat.campaigns.components import Component, Options
from gyrostat.campaigns.schema import positive, size
from gyrostat.control import (
    AttitudeRegulator,
    AttitudeTargets,
    MinimaxAllocation,
    MomentumRecovery,
    MomentumUnloading,
    NullSpaceControl,
    PseudoInverse,
    WheelArrayControl,
    WheelFaultDetector,
)
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import check_parts
from gyrostat.spacecraft import Spacecraft

NOTIFIED, DETECTED, IGNORED = "notified", "detected", "ignored"
"""Handling of wheel failures: the controller is notified, detects them itself, or ignores them."""


class DesignCase(NamedTuple):
    """Design case of a controller.

    Attributes:
        spacecraft: Nominal spacecraft, the model of the controller.
        working: Whether the controller may use each wheel, (wheels,).
        seized: Whether each failed wheel has seized, (wheels,).
        target: Target attitude, (4,), scalar first.
        delay: Control periods from a sample to the start of its command.
    """

    spacecraft: Spacecraft
    working: np.ndarray
    seized: np.ndarray
    target: np.ndarray
    delay: int


@dataclass(frozen=True)
class PlannedController(Component):
    """Controller that is designed once for each target and for each notified wheel failure.

    Attributes:
        make: (design, options, total momentum (3,), N·m·s) -> controller.
        plan: `DesignCase` -> design, computed outside the loop. Designs of one scenario have the
            same structure. Raises `InputError` if the wheels do not suffice.
        losses: Handling of wheel failures: NOTIFIED, DETECTED or IGNORED.
        follows: Whether the controller can follow a reference that moves.
    """

    plan: Callable[[DesignCase], Any]
    losses: str = NOTIFIED
    follows: bool = True


def _plan_three_axis(case: DesignCase) -> MomentumRecovery:
    found = MomentumRecovery.plan(
        case.spacecraft,
        case.working,
        seized=case.seized,
        target=case.target,
        total_momentum=np.zeros(3),
    )
    return eqx.tree_at(lambda f: f.law.wheels, found, replace(found.law.wheels, delay=case.delay))


def _three_axis(plan: MomentumRecovery, options: Options, momentum: Vector3) -> MomentumRecovery:
    loop = replace(plan.law.wheels, gain=options["rate_gain"], drag_time=options["drag_time"])
    law = replace(
        plan.law,
        wheels=loop,
        total_momentum=momentum,
        turn_gain=options["turn_gain"],
        largest_rate=options["largest_rate"],
    )
    return replace(plan, law=law, torque_time=options["torque_time"])


def _plan_array(allocation: Any) -> Callable[[DesignCase], WheelArrayControl]:
    def plan(case: DesignCase) -> WheelArrayControl:
        wheels, null_space = case.spacecraft.wheels, None
        if wheels.count > 3:
            null_space = NullSpaceControl.plan(wheels.axes, wheels.momentum_limit)
        found = WheelArrayControl(
            case.spacecraft,
            AttitudeTargets.hold(case.target),
            allocation=allocation,
            null_space=null_space,
            detector=WheelFaultDetector(
                notified=np.where(case.working, np.inf, 0.0), delay=case.delay
            ),
        )
        check_parts(found)
        return found

    return plan


def _array(plan: WheelArrayControl, options: Options, momentum: Vector3) -> WheelArrayControl:
    limit = options["external_torque_limit"] * jnp.ones(3)
    null_space = plan.null_space
    if null_space is not None:
        null_space = replace(null_space, gain=options["null_space_gain"])
    return replace(
        plan,
        turn_gain=options["turn_gain"],
        rate_gain=options["rate_gain"],
        torque_time=options["torque_time"],
        largest_rate=options["largest_rate"],
        null_space=null_space,
        unloading=MomentumUnloading(limit, options["momentum_gain"]),
        detector=replace(plan.detector, drag_time=options["drag_time"]),
    )


def _detecting(plan: WheelArrayControl, options: Options, momentum: Vector3) -> WheelArrayControl:
    found = _array(plan, options, momentum)
    names = ("failure_torque", "failure_time")
    return replace(
        found, detector=replace(found.detector, **{name: options[name] for name in names})
    )


def _plan_regulator(case: DesignCase) -> AttitudeRegulator:
    found = AttitudeRegulator(case.spacecraft, jnp.asarray(case.target))
    check_parts(found)
    return found


def _regulator(plan: AttitudeRegulator, options: Options, momentum: Vector3) -> AttitudeRegulator:
    return replace(plan, **options)


def _linear(plan: AttitudeRegulator, options: Options, momentum: Vector3) -> AttitudeRegulator:
    return replace(plan, **options).linear()


_TORQUE_TIME = positive(
    "time",
    inf,
    "Time constant of the estimate of the external torque, which the wheels then take up; none: no "
    "estimate, and an external torque causes a constant attitude error.",
)
_REGULATOR_KEYS = {
    "attitude_weight": positive(
        "1", 16.0, "Weight on the squared modified Rodrigues parameters (small angle / 4)."
    ),
    "rate_weight": positive("s²/rad²", 16.0, "Weight on the squared body rate."),
    "torque_weight": positive("1/(N·m)²", 1.0, "Weight on the squared body torque."),
    "torque_time": _TORQUE_TIME,
}
_ARRAY_KEYS = {
    "turn_gain": positive("1/s", 0.1, "Commanded rate per attitude error near the target."),
    "rate_gain": positive("1/s", 0.4, "Gain of the rate loop."),
    "torque_time": positive("time", 20.0, "Time constant of the external torque estimate."),
    "largest_rate": positive("speed", 0.05, "Largest slew rate."),
    "drag_time": positive("time", 10.0, "Time constant of the wheel drag estimate."),
    "null_space_gain": positive(
        "1/s", 0.05, "Gain of the null-space control of wheel speeds, for four or more wheels."
    ),
    "external_torque_limit": size(
        "torque",
        0.0,
        "Torque limit of the actuator that unloads the wheels, about each body axis; 0: no "
        "actuator.",
    ),
    "momentum_gain": positive("1/s", 1e-3, "Gain of the momentum unloading."),
}


CONTROLLERS: dict[str, PlannedController] = {
    "three_axis": PlannedController(
        "Three-axis control: rotation about the axis of the attitude error within the limits of "
        "the wheels (`gyrostat.control.ThreeAxisLaw`), with a slow estimate of the wheel drag.",
        {
            "turn_gain": positive(
                "1/s", 0.25, "Commanded rate per attitude error near the target."
            ),
            "largest_rate": positive("speed", 0.1, "Largest slew rate."),
            "rate_gain": positive("1/s", 0.8, "Gain of the rate loop."),
            "drag_time": positive("time", 10.0, "Time constant of the wheel drag estimate."),
            "torque_time": _TORQUE_TIME,
        },
        _three_axis,
        _plan_three_axis,
    ),
    "wheel_array": PlannedController(
        "Control of any number of wheels (`gyrostat.control.WheelArrayControl`): minimax torque "
        "allocation, null-space control away from zero speed and saturation, estimates of drag "
        "and external torque, momentum unloading.",
        _ARRAY_KEYS,
        _array,
        _plan_array(MinimaxAllocation()),
    ),
    "wheel_array_pseudo_inverse": PlannedController(
        "As `wheel_array`, with torque allocation by the pseudo-inverse (least sum of squares).",
        _ARRAY_KEYS,
        _array,
        _plan_array(PseudoInverse()),
    ),
    "wheel_array_detecting": PlannedController(
        "As `wheel_array`, but the controller is not notified of wheel failures; it detects them. "
        "If a wheel gives `failure_torque` less than commanded, it is declared failed for the rest "
        "of the run. Choose `failure_torque` above the drag of the bearings and below half the "
        "torque limit, up to which drag compensation raises the command to a failed motor.",
        {
            **_ARRAY_KEYS,
            "failure_torque": positive(
                "torque", None, "Lost torque above which a wheel is declared failed."
            ),
            "failure_time": positive(
                "time", 5.0, "Time constant of the low-pass filter of the lost torque."
            ),
        },
        _detecting,
        _plan_array(MinimaxAllocation()),
        DETECTED,
    ),
    "lqr": PlannedController(
        "Linear quadratic regulator: state feedback of attitude and rate "
        "(`gyrostat.control.AttitudeRegulator`), without a rate limit. Failed wheels and "
        "drag are not taken into account.",
        _REGULATOR_KEYS,
        _linear,
        _plan_regulator,
        IGNORED,
    ),
    "sdre": PlannedController(
        "As `lqr`, with the state-dependent Riccati equation (SDRE), solved at each sample.",
        _REGULATOR_KEYS,
        _regulator,
        _plan_regulator,
        IGNORED,
    ),
}
