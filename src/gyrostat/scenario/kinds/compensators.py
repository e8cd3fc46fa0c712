"""Compensators that a scenario can name, one entry each."""

from dataclasses import replace
from typing import Any

from gyrostat.control import (
    EstimatingFeedForward,
    FrictionFeedForward,
    FrictionFilterFeedForward,
)
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import FrictionTorqueFilter
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.schema import positive, size
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.friction import static_curve

PULSE_SHARE = 0.2
"""Standard deviation of a tachometer that counts pulses, over the speed of one pulse."""
LEAST_NOISE, LEAST_RATE_NOISE = 1e-3, 1e-7
"""Smallest noise of tachometer and gyro that the compensator `estimating` assumes, rad/s."""


def _friction_model(
    options: Options, controller: Any, known: Spacecraft, delay: int, *others: Any
) -> FrictionFeedForward:
    wheels = known.wheels
    return FrictionFeedForward(
        controller,
        static_curve(wheels.friction),
        jnp.asarray(wheels.torque_limit),
        **options,
    )


def _friction_filter(
    options: Options, controller: Any, known: Spacecraft, delay: int, *others: Any
) -> FrictionFilterFeedForward:
    wheels = known.wheels
    return FrictionFilterFeedForward(
        controller,
        FrictionTorqueFilter(**options),
        jnp.asarray(wheels.axes),
        jnp.asarray(wheels.inertia),
        jnp.asarray(wheels.torque_limit),
        delay,
    )


def _estimating(
    options: Options,
    controller: Any,
    known: Spacecraft,
    delay: int,
    period: Scalar,
    sensors: Options,
) -> EstimatingFeedForward:
    own = {"wheel_sigma": 0.0, "rate_sigma": 0.0, "angle_walk": 0.0, **sensors}
    counted = jnp.asarray(own["tachometer_pulses"])
    pulse = 2.0 * jnp.pi / (jnp.where(counted > 0.0, counted, jnp.inf) * period)
    older = jnp.max(own["wheel_sigma"] / jnp.asarray(known.wheels.inertia))
    speed = jnp.sqrt(own["speed_sigma"] ** 2 + older**2 + (PULSE_SHARE * pulse) ** 2)
    rate = jnp.sqrt(own["rate_sigma"] ** 2 + own["angle_walk"] ** 2 / period)
    given, known_rate = options["speed_sigma"], options["rate_sigma"]
    made = EstimatingFeedForward.tuned(
        controller,
        known,
        speed_sigma=jnp.maximum(jnp.where(given > 0.0, given, speed), LEAST_NOISE),
        rate_sigma=jnp.maximum(jnp.where(known_rate > 0.0, known_rate, rate), LEAST_RATE_NOISE),
        period=period,
        bandwidth=options["bandwidth"],
        delay=delay,
    )
    own_numbers = ("gain", "band", "softness", "doubt", "largest")
    return replace(made, **{name: options[name] for name in own_numbers})


COMPENSATORS: dict[str, Component] = {
    "none": Component("No compensator.", {}, lambda options, controller, *others: controller),
    "friction_model": Component(
        "Friction feed-forward from the nominal friction model at the measured speed "
        "(`gyrostat.control.FrictionFeedForward`).",
        {
            "band": positive("speed", 1.0, "Speed below which the sign of the speed is ignored."),
            "share": size("1", 1.0, "Fraction of the friction torque that is compensated."),
        },
        _friction_model,
    ),
    "friction_filter": Component(
        "Friction feed-forward from a Kalman filter, which estimates the friction torque from the "
        "measured momentum and the commanded torque of each wheel, without a friction model "
        "(`gyrostat.control.FrictionFilterFeedForward`).",
        {
            "momentum_sigma": positive(
                "momentum", None, "Standard deviation of a measured wheel momentum."
            ),
            "torque_drift": positive("N·m/√s", None, "Random walk of the friction torque."),
            "initial_sigma": positive(
                "1",
                0.1,
                "Initial standard deviation of momentum, N·m·s, and of friction torque, N·m.",
            ),
        },
        _friction_filter,
    ),
    "estimating": Component(
        "Friction feed-forward from the nominal friction model and the friction that a filter for "
        "each wheel finds beyond it, from gyro, tachometer and conservation of momentum "
        "(`gyrostat.control.EstimatingFeedForward`).",
        {
            "speed_sigma": size(
                "speed",
                0.0,
                "Standard deviation of a tachometer sample; 0: that of the nominal sensors, with a "
                "fifth of the speed of one pulse.",
            ),
            "rate_sigma": size(
                "speed",
                0.0,
                "Standard deviation of each component of the measured rate; 0: that of the nominal "
                "sensors.",
            ),
            "bandwidth": positive(
                "rad/s", 0.6, "Bandwidth of the friction estimate of a wheel that turns."
            ),
            "gain": size("1/s", 1.0, "Gain by which the momentum lost to friction is returned."),
            "band": positive(
                "1",
                3.0,
                "Speed at which the compensation is complete without needed torque, in standard "
                "deviations of the speed.",
            ),
            "softness": positive(
                "1",
                0.6,
                "Needed torque over breakaway torque at which the compensation at rest is "
                "complete.",
            ),
            "doubt": size(
                "1",
                0.5,
                "Standard deviation of the friction of a wheel whose direction is not known, over "
                "the breakaway torque.",
            ),
            "largest": positive(
                "1", 3.0, "Largest compensated friction torque over that of the model."
            ),
        },
        _estimating,
        needs=("gyro",),
    ),
}
