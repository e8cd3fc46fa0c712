"""Controllers of wheel arrays that a scenario can name, one entry each."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from gyrostat.control import (
    AttitudeTargets,
    MinimaxAllocation,
    MomentumUnloading,
    NullSpaceControl,
    PseudoInverse,
    WheelArrayControl,
    WheelFaultDetector,
    WheelWear,
)
from gyrostat.core.arrays import Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.kinds.controllers import DETECTED, DesignCase, PlannedController
from gyrostat.scenario.schema import positive, size


def _plan_array(allocation: Any) -> Callable[[DesignCase], WheelArrayControl]:
    def plan(case: DesignCase) -> WheelArrayControl:
        wheels, null_space = case.spacecraft.wheels, None
        if wheels.count > 3:
            null_space = NullSpaceControl.plan(wheels.axes, wheels.momentum_limit)
        return WheelArrayControl(
            case.spacecraft,
            AttitudeTargets.hold(case.target),
            allocation=allocation,
            null_space=null_space,
            detector=WheelFaultDetector(
                notified=np.where(case.working, np.inf, 0.0), delay=case.delay
            ),
        )

    return plan


def _array(plan: WheelArrayControl, options: Options, momentum: Vector3) -> WheelArrayControl:
    limit = options["external_torque_limit"] * jnp.ones(3)
    null_space, inertia = plan.null_space, jnp.asarray(plan.spacecraft.wheels.inertia)
    if null_space is not None:
        bands = [
            [band["above"] * inertia, band["below"] * inertia]
            for band in options.get("bands", {}).values()
        ]
        null_space = replace(
            null_space,
            gain=options["null_space_gain"],
            bands=jnp.array(bands) if bands else None,
            clearance=options["clearance"] * jnp.max(inertia),
            crossing_gain=options["crossing_gain"],
        )
    return replace(
        plan,
        wear=WheelWear(options.get("wear", 1.0) * jnp.ones(len(inertia)), options["wear_time"]),
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


LARGEST_RATE_GAIN, SMALLEST_TURN_GAIN = 0.8, 0.05
"""Bounds of the default gains, 1/s."""
GAIN_RATIO = 0.3125
"""Default turn gain over rate gain."""
LARGEST_LAG = 0.4
"""Largest product of default rate gain and mean age of a command. With `GAIN_RATIO` the loop gain
is 1 at 1.04 times the rate gain, so that the phase margin is 73 deg - 1.04 x 0.4 rad = 49 deg."""


def default_gains(values: Mapping[str, float], delay: int) -> dict[str, float]:
    """Default gains of a wheel array, 1/s, from control period, command delay and sensor noise.

    The rate gain is limited by the age of the commands. White noise of rate and attitude with the
    standard deviations s_w and s_a causes an attitude error of variance T (s_w²/k_t + k_t s_a²)/2
    in a loop with turn gain k_t and control period T. The turn gain is that of the smallest error,
    s_w / s_a, within bounds.

    Args:
        values: Values of the other sections.
        delay: Command delay, periods.
    """
    age = values["run.control_period"] * max(1.0, delay + 0.5)
    rate_gain = min(LARGEST_RATE_GAIN, LARGEST_LAG / age)
    turn_gain = GAIN_RATIO * rate_gain
    rate, attitude = (values.get(f"sensors.{name}_sigma", 0.0) for name in ("rate", "attitude"))
    if "sensors.rate_sigma" in values and attitude > 0.0:
        best = max(rate / attitude, SMALLEST_TURN_GAIN)
        turn_gain = min(turn_gain, best)
    return {"rate_gain": rate_gain, "turn_gain": turn_gain}


_ARRAY_KEYS = {
    "turn_gain": positive(
        "1/s",
        GAIN_RATIO * LARGEST_RATE_GAIN,
        "Commanded rate per attitude error near the target. The default is at most 0.3125 times "
        "the rate gain, and at most the noise of the rate over that of the attitude, but not below "
        "0.05 for that reason.",
    ),
    "rate_gain": positive(
        "1/s",
        LARGEST_RATE_GAIN,
        "Gain of the rate loop. The default is at most 0.4 over the age of the commands: the "
        "control period, times the command delay and a half if there is a delay.",
    ),
    "torque_time": positive("time", 20.0, "Time constant of the external torque estimate."),
    "largest_rate": positive("speed", 0.05, "Largest slew rate."),
    "drag_time": positive("time", 10.0, "Time constant of the wheel drag estimate."),
    "null_space_gain": size(
        "1/s",
        0.05,
        "Gain of the null-space control of wheel speeds, for four or more wheels; 0: none.",
    ),
    "clearance": positive(
        "speed",
        inf,
        "Distance of wheel speeds from zero and from `[[controller.band]]` that suffices; none: as "
        "far as possible.",
    ),
    "crossing_gain": positive(
        "1/s", 0.2, "Gain of the null-space control while wheels cross zero or a band."
    ),
    "wear_time": positive(
        "time",
        inf,
        "Time constant of the estimate of wear, the friction of each wheel over that of its model; "
        "none: no estimate.",
    ),
    "external_torque_limit": size(
        "torque",
        0.0,
        "Torque limit of the actuator that unloads the wheels, about each body axis; 0: no "
        "actuator.",
    ),
    "momentum_gain": positive("1/s", 1e-3, "Gain of the momentum unloading."),
}
BANDS: dict[str, Component] = {
    "speeds": Component(
        "Wheel speeds of either sign that the null-space control of a `wheel_array` avoids.",
        {
            "above": size("speed", 0.0, "Lower end of the band."),
            "below": positive("speed", None, "Upper end of the band."),
        },
        lambda options, **given: options,
    ),
}
"""Kinds of [[controller.band]]; `_array` reads their numbers."""
ARRAY_CONTROLLERS: dict[str, PlannedController] = {
    "wheel_array": PlannedController(
        "Control of any number of wheels (`gyrostat.control.WheelArrayControl`): minimax torque "
        "allocation, null-space control away from zero speed and saturation, estimates of drag "
        "and external torque, momentum unloading.",
        _ARRAY_KEYS,
        _array,
        _plan_array(MinimaxAllocation()),
        defaults=default_gains,
    ),
    "wheel_array_pseudo_inverse": PlannedController(
        "As `wheel_array`, with torque allocation by the pseudo-inverse (least sum of squares).",
        _ARRAY_KEYS,
        _array,
        _plan_array(PseudoInverse()),
        defaults=default_gains,
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
        defaults=default_gains,
    ),
}
