"""Plants, sensors and environments that a scenario can name, one entry each.

To add a component is to add an entry: its keys, and how it is made of their values.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from gyrostat.campaigns.schema import Key, positive, size, vector
from gyrostat.control import FrictionFeedForward, FrictionFilterFeedForward, OutputFeedback
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import AttitudeFilter, FrictionTorqueFilter
from gyrostat.spacecraft import (
    CircularOrbit,
    GravityGradient,
    HarmonicTorque,
    RateGyro,
    Spacecraft,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)
from gyrostat.spacecraft.environment import EARTH, EARTH_RADIUS
from gyrostat.wheel import WheelTachometer

Options = Mapping[str, Scalar]
"""Values of a component's keys, SI."""


@dataclass(frozen=True)
class Component:
    """A part of the loop.

    Attributes:
        meaning: one sentence for the documentation.
        keys: of its numbers.
        make: from their values and what it is made for; traced, so no check of values.
    """

    meaning: str
    keys: Mapping[str, Key]
    make: Callable[..., Any]


def _friction_model(
    options: Options, controller: Any, known: Spacecraft, delay: int
) -> FrictionFeedForward:
    wheels = known.wheels
    return FrictionFeedForward(
        controller,
        wheels.friction,
        jnp.asarray(wheels.torque_limit),
        options["band"],
        options["share"],
    )


def _friction_filter(
    options: Options, controller: Any, known: Spacecraft, delay: int
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


def _tachometer(options: Options, known: Spacecraft) -> WheelTachometer:
    # noise of a momentum is noise of a speed times the inertia that it was worked out with
    older = options["wheel_sigma"] / jnp.asarray(known.wheels.inertia)
    return WheelTachometer(
        jnp.hypot(options["speed_sigma"], older),
        options["tachometer_pulses"],
        options["tachometer_lag"],
    )


def _white_noise(options: Options, plant: Any, known: Spacecraft) -> SpacecraftSensor:
    return SpacecraftSensor(
        plant,
        options["attitude_sigma"],
        options["rate_sigma"],
        tachometer=_tachometer(options, known),
    )


def stacked(options: Options, name: str) -> Vector3:
    """The vector whose components are the values of its keys."""
    return jnp.stack([jnp.asarray(options[f"{name}.{axis}"], dtype=float) for axis in "xyz"])


def _tracker_gyro(options: Options, plant: Any, known: Spacecraft) -> TrackerGyroSensors:
    numbers = ("angle_walk", "bias_walk", "rate_limit", "coning_compensation")
    vectors = ("bias", "scale_factor", "misalignment")
    return TrackerGyroSensors(
        SpacecraftSensor(plant, tachometer=_tachometer(options, known)),
        StarTracker(options["attitude_sigma"], jnp.round(options["tracker_periods"])),
        RateGyro(
            **{name: options[name] for name in numbers},
            **{name: stacked(options, name) for name in vectors},
        ),
    )


def _kalman(options: Options, controller: Any, sensors: Options) -> OutputFeedback:
    names = ("attitude_sigma", "angle_walk", "bias_walk")
    noise = {name: sensors[name] for name in names}
    # what the gyro does not compensate for is left to the filter
    coning = 1.0 - sensors["coning_compensation"]
    return OutputFeedback(AttitudeFilter(**noise, **options, coning=coning), controller)


def _constant_torque(options: Options) -> dict[str, Any]:
    return {"external_torque": stacked(options, "external_torque")}


def _in_orbit(options: Options) -> dict[str, Any]:
    rate = jnp.sqrt(EARTH / (EARTH_RADIUS + options["altitude"]) ** 3)
    names = ("inclination", "ascending_node", "latitude")
    orbit = CircularOrbit(rate, **{name: options[name] for name in names})
    harmonic = HarmonicTorque(
        rate,
        cosine=stacked(options, "cosine_torque")[None],
        sine=stacked(options, "sine_torque")[None],
    )
    return {**_constant_torque(options), "environment": (GravityGradient(orbit), harmonic)}


COMPENSATORS: dict[str, Component] = {
    "none": Component("None.", {}, lambda options, controller, known, delay: controller),
    "friction_model": Component(
        "Adds the friction of the wheel's nominal model at the measured speed "
        "(`gyrostat.control.FrictionFeedForward`).",
        {
            "band": positive("speed", 1.0, "Speed below which its sign counts for nothing."),
            "share": size("1", 1.0, "Of the friction that is compensated."),
        },
        _friction_model,
    ),
    "friction_filter": Component(
        "Adds the friction that a Kalman filter finds from the measured momentum and the commanded "
        "torque of each wheel, without a friction model "
        "(`gyrostat.control.FrictionFilterFeedForward`).",
        {
            "momentum_sigma": positive("momentum", None, "Noise of a wheel's measured momentum."),
            "torque_drift": positive(
                "N·m/√s", None, "Of the friction torque in the square root of a second."
            ),
            "initial_sigma": positive(
                "1", 0.1, "Of momentum, N·m·s, and of friction, N·m, before anything is measured."
            ),
        },
        _friction_filter,
    ),
}
_TACHOMETER = {
    "speed_sigma": size("speed", 0.0, "Noise of a tachometer sample."),
    "tachometer_pulses": size("1", 0.0, "In one revolution, counted over a period; 0: not."),
    "tachometer_lag": size("time", 0.0, "Time constant of the tachometer's low pass; 0: none."),
    "wheel_sigma": size(
        "momentum",
        0.0,
        "Older form of `speed_sigma`, times the nominal rotor inertia; both add in quadrature.",
    ),
}
SENSORS: dict[str, Component] = {
    "white_noise": Component(
        "Attitude and rate with white noise, wheel speeds from tachometers "
        "(`gyrostat.spacecraft.SpacecraftSensor`, `gyrostat.wheel.WheelTachometer`).",
        {
            "attitude_sigma": size("angle", 0.0, "Of a sample about each body axis."),
            "rate_sigma": size("speed", 0.0, "Of a sample of each component."),
            **_TACHOMETER,
        },
        _white_noise,
    ),
    "star_tracker_gyro": Component(
        "Star tracker, gyro and tachometers (`gyrostat.spacecraft.TrackerGyroSensors`), for the "
        "estimator `kalman`. The gyro gives the integral of the body rate over the period "
        "(`gyrostat.spacecraft.RateGyro`).",
        {
            "attitude_sigma": positive("angle", None, "Of a sample of the star tracker."),
            "tracker_periods": Key(
                "1",
                1.0,
                "Control periods between its samples, rounded to a whole number.",
                least=1.0,
            ),
            "angle_walk": positive("rad/√s", None, "Of the gyro: its integrated noise."),
            "bias_walk": size("rad/s/√s", 0.0, "Of the gyro: how its bias walks."),
            "bias": vector("speed", "Of the gyro, at the start."),
            "scale_factor": Key(
                "1", 0.0, "Relative error of each gyro axis.", least=-1.0, positive=True, size=3
            ),
            "misalignment": vector("angle", "Rotation vector from body to gyro axes."),
            "rate_limit": positive("speed", inf, "Largest rate that a gyro axis measures."),
            "coning_compensation": Key(
                "1", 0.0, "Share of the coning that the gyro compensates for.", least=0.0, most=1.0
            ),
            **_TACHOMETER,
        },
        _tracker_gyro,
    ),
}
ESTIMATORS: dict[str, Component] = {
    "none": Component("None.", {}, lambda options, controller, sensors: controller),
    "kalman": Component(
        "Attitude and gyro bias by the multiplicative Kalman filter "
        "(`gyrostat.estimation.AttitudeFilter`), which takes the noise of the sensors to be "
        "nominal.",
        {"bias_sigma": positive("speed", 1e-4, "Of the gyro's bias before anything is measured.")},
        _kalman,
    ),
}
ESTIMATOR_OF = {"white_noise": "none", "star_tracker_gyro": "kalman"}
"""Sensors -> the estimator that makes of them what controllers need."""
_EXTERNAL = {"external_torque": vector("torque", "Constant torque from outside, in body axes.")}
ENVIRONMENTS: dict[str, Component] = {
    "constant": Component("A torque that stays.", _EXTERNAL, _constant_torque),
    "orbit": Component(
        "A circular orbit of the Earth: gravity gradient "
        "(`gyrostat.spacecraft.GravityGradient`), a "
        "constant torque and one with the period of the orbit "
        "(`gyrostat.spacecraft.HarmonicTorque`).",
        {
            **_EXTERNAL,
            "altitude": positive("m", None, "Above the equator's radius."),
            "inclination": Key("angle", 0.0, "To the inertial x-y plane."),
            "ascending_node": Key("angle", 0.0, "From x towards y."),
            "latitude": Key("angle", 0.0, "From the ascending node, at the start."),
            "cosine_torque": vector("torque", "Times the cosine of the orbit's phase since then."),
            "sine_torque": vector("torque", "Times its sine."),
        },
        _in_orbit,
    ),
}
"""Kind -> torques from outside; gives the arguments of `gyrostat.spacecraft.Gyrostat`."""
