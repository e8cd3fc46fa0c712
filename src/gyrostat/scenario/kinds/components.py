"""Sensors and estimators that a scenario can name, one entry each.

To add a component, add an entry: its keys, and a function that builds it from their values.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from math import inf
from typing import Any

from gyrostat.control import OutputFeedback
from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import AttitudeFilter, MomentumAttitudeFilter
from gyrostat.scenario.schema import GYROLESS, Key, positive, size, vector
from gyrostat.spacecraft import (
    RateGyro,
    Spacecraft,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)
from gyrostat.wheel import WheelTachometer

Options = dict[str, Any]
"""Values of the keys of a component, SI: numbers, or arrays of the shape of the key."""


@dataclass(frozen=True)
class Component:
    """Part of the control loop that a scenario can name.

    Attributes:
        meaning: One sentence for the documentation.
        keys: Keys of its parameters.
        make: Function of their values and of other parts that builds it. It is traced by JAX, so
            that it cannot validate values.
        unit: Unit of the value of a sensor or metric.
        texts: Names of keys that are texts; their reader stores them.
        needs: What the scenario must have for it, keys of `gyrostat.scenario.kinds.registry.NEEDS`.
        defaults: (values of the other sections, command delay in periods) -> defaults of some keys,
            SI, that replace those of `keys`.
    """

    meaning: str
    keys: Mapping[str, Key]
    make: Callable[..., Any]
    unit: str = field(default="1", kw_only=True)
    texts: tuple[str, ...] = field(default=(), kw_only=True)
    needs: tuple[str, ...] = field(default=(), kw_only=True)
    defaults: Callable[[Mapping[str, float], int], Mapping[str, float]] = field(
        default=lambda values, delay: {}, kw_only=True
    )


def _speed_sigma(options: Options, known: Spacecraft) -> PerWheel:
    # noise of the momentum is noise of the speed times the nominal inertia
    older = options["wheel_sigma"] / jnp.asarray(known.wheels.inertia)
    return jnp.hypot(options["speed_sigma"], older)


def _tachometer(options: Options, known: Spacecraft) -> WheelTachometer:
    return WheelTachometer(
        _speed_sigma(options, known),
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


def _tracker_gyro(options: Options, plant: Any, known: Spacecraft) -> TrackerGyroSensors:
    names = [field.name for field in fields(RateGyro)]
    gyro = RateGyro(**{name: options[name] for name in names})
    return replace(_tracker(options, plant, known), gyro=gyro)


def _tracker(options: Options, plant: Any, known: Spacecraft) -> TrackerGyroSensors:
    return TrackerGyroSensors(
        SpacecraftSensor(plant, tachometer=_tachometer(options, known)),
        StarTracker(options["attitude_sigma"], jnp.round(options["tracker_periods"])),
    )


def _kalman(
    options: Options, controller: Any, known: Spacecraft, sensors: Options
) -> OutputFeedback:
    names = ("attitude_sigma", "angle_walk", "bias_walk")
    noise = {name: sensors[name] for name in names}
    # the filter corrects the remaining coning
    coning = 1.0 - sensors["coning_compensation"]
    return OutputFeedback(AttitudeFilter(**noise, **options, coning=coning), controller)


def _momentum(
    options: Options, controller: Any, known: Spacecraft, sensors: Options
) -> OutputFeedback:
    filter = MomentumAttitudeFilter(
        known,
        sensors["attitude_sigma"],
        jnp.round(sensors["tracker_periods"]),
        _speed_sigma(sensors, known),
        **options,
    )
    return OutputFeedback(filter, controller)


_TRACKER = {
    "attitude_sigma": positive(
        "angle", None, "Standard deviation of the star tracker about each body axis."
    ),
    "tracker_periods": Key(
        "1",
        1.0,
        "Control periods between star tracker samples, rounded to a whole number.",
        least=1.0,
    ),
}
_TACHOMETER = {
    "speed_sigma": size("speed", 0.0, "Standard deviation of a tachometer sample."),
    "tachometer_pulses": size(
        "1", 0.0, "Pulses per revolution, counted over a control period; 0: no quantisation."
    ),
    "tachometer_lag": size(
        "time", 0.0, "Time constant of the low-pass filter of the tachometer; 0: no filter."
    ),
    "wheel_sigma": size(
        "momentum",
        0.0,
        "Older form of `speed_sigma`: `speed_sigma` times the nominal rotor inertia; both add in "
        "quadrature.",
    ),
}
SENSORS: dict[str, Component] = {
    "white_noise": Component(
        "Attitude and rate with white noise, wheel speeds from tachometers "
        "(`gyrostat.spacecraft.SpacecraftSensor`, `gyrostat.wheel.WheelTachometer`).",
        {
            "attitude_sigma": size(
                "angle", 0.0, "Standard deviation of the attitude about each body axis."
            ),
            "rate_sigma": size(
                "speed", 0.0, "Standard deviation of each component of the body rate."
            ),
            **_TACHOMETER,
        },
        _white_noise,
    ),
    "star_tracker_gyro": Component(
        "Star tracker, gyro and tachometers (`gyrostat.spacecraft.TrackerGyroSensors`), for the "
        "estimator `kalman`. The gyro gives the integral of the body rate over the period "
        "(`gyrostat.spacecraft.RateGyro`).",
        {
            **_TRACKER,
            "angle_walk": positive("angle_random_walk", None, "Angle random walk of the gyro."),
            "bias_walk": size("rate_random_walk", 0.0, "Random walk of the gyro bias."),
            "bias": vector("speed", "Initial bias of the gyro."),
            "scale_factor": Key(
                "1",
                0.0,
                "Scale factor error of each gyro axis.",
                least=-1.0,
                positive=True,
                shape=(3,),
            ),
            "misalignment": vector("angle", "Rotation vector from body to gyro axes."),
            "rate_limit": positive("speed", inf, "Largest rate that a gyro axis measures."),
            "coning_compensation": size(
                "1", 0.0, "Fraction of the coning for which the gyro compensates.", most=1.0
            ),
            **_TACHOMETER,
        },
        _tracker_gyro,
    ),
    GYROLESS: Component(
        "Star tracker and tachometers, without a gyro "
        "(`gyrostat.spacecraft.TrackerGyroSensors`), for the estimator `momentum`.",
        {**_TRACKER, **_TACHOMETER},
        _tracker,
    ),
}
ESTIMATORS: dict[str, Component] = {
    "none": Component("No estimator.", {}, lambda options, controller, known, sensors: controller),
    "kalman": Component(
        "Multiplicative Kalman filter for attitude and gyro bias "
        "(`gyrostat.estimation.AttitudeFilter`). It assumes the nominal sensor noise.",
        {"bias_sigma": positive("speed", 1e-4, "Initial standard deviation of the gyro bias.")},
        _kalman,
    ),
    "momentum": Component(
        "Kalman filter for attitude, total momentum and rotor inertias, without a gyro: the body "
        "rate follows from the total momentum and the wheel speeds "
        "(`gyrostat.estimation.MomentumAttitudeFilter`). It assumes the nominal sensor noise. It "
        "needs tachometers that work.",
        {
            "bandwidth": positive("rad/s", 0.2, "Bandwidth of the filter."),
            "rotor_sigma": size(
                "1",
                0.1,
                "Relative standard deviation of the rotor inertias over the body inertia; 0: those "
                "of the model are trusted.",
            ),
            "rate_sigma": positive(
                "speed", 0.01, "Standard deviation of the body rate at the start about each axis."
            ),
        },
        _momentum,
    ),
}
ESTIMATOR_OF = {"white_noise": "none", "star_tracker_gyro": "kalman", GYROLESS: "momentum"}
"""Sensors -> estimator that they require."""
