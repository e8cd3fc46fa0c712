"""Controllers that a scenario can name, one entry each."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np

from gyrostat.control import (
    AttitudeRegulator,
    MomentumRecovery,
)
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.schema import positive
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


def _plan_regulator(case: DesignCase) -> AttitudeRegulator:
    return AttitudeRegulator(case.spacecraft, jnp.asarray(case.target))


def _regulator(plan: AttitudeRegulator, options: Options, momentum: Vector3) -> AttitudeRegulator:
    return replace(plan, **options)


def _linear(plan: AttitudeRegulator, options: Options, momentum: Vector3) -> AttitudeRegulator:
    return replace(plan, **options).linear()


_TORQUE_TIME = replace(
    positive(
        "time",
        20.0,
        "Time constant of the estimate of the external torque, which the wheels take up; "
        '`"none"`: no estimate, and an external torque causes a constant attitude error.',
    ),
    unlimited=True,
)
_REGULATOR_KEYS = {
    "attitude_weight": positive(
        "1", 16.0, "Weight on the squared modified Rodrigues parameters (small angle / 4)."
    ),
    "rate_weight": positive("s²/rad²", 16.0, "Weight on the squared body rate."),
    "torque_weight": positive("1/(N·m)²", 1.0, "Weight on the squared body torque."),
    "torque_time": _TORQUE_TIME,
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
