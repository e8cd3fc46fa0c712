"""Compensators, sensors, estimators and environments that a scenario can name, one entry each.

To add a component, add an entry: its keys, and a function that builds it from their values.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
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
"""Values of the keys of a component, SI."""


@dataclass(frozen=True)
class Component:
    """Part of the control loop that a scenario can name.

    Attributes:
        meaning: One sentence for the documentation.
        keys: Keys of its parameters.
        make: Function of their values and of other parts that builds it. It is traced by JAX, so
            that it cannot validate values.
        unit: Unit of the value of a sensor.
        texts: Names of keys that are texts; their reader stores them.
    """

    meaning: str
    keys: Mapping[str, Key]
    make: Callable[..., Any]
    unit: str = field(default="1", kw_only=True)
    texts: tuple[str, ...] = field(default=(), kw_only=True)


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
    # noise of the momentum is noise of the speed times the nominal inertia
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
    """Vector from the values of its component keys, (3,)."""
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


def _kalman(
    options: Options, controller: Any, known: Spacecraft, sensors: Options
) -> OutputFeedback:
    names = ("attitude_sigma", "angle_walk", "bias_walk")
    noise = {name: sensors[name] for name in names}
    # the filter corrects the remaining coning
    coning = 1.0 - sensors["coning_compensation"]
    return OutputFeedback(AttitudeFilter(**noise, **options, coning=coning), controller)


def _constant_torque(options: Options) -> dict[str, Any]:
    return {"external_torque": stacked(options, "external_torque")}


def orbit_of(options: Options) -> CircularOrbit:
    """Circular orbit from the values of the keys `ORBIT`."""
    rate = jnp.sqrt(EARTH / (EARTH_RADIUS + options["altitude"]) ** 3)
    names = ("inclination", "ascending_node", "latitude")
    return CircularOrbit(rate, **{name: options[name] for name in names})


def _in_orbit(options: Options) -> dict[str, Any]:
    orbit = orbit_of(options)
    harmonic = HarmonicTorque(
        orbit.rate,
        cosine=stacked(options, "cosine_torque")[None],
        sine=stacked(options, "sine_torque")[None],
    )
    return {**_constant_torque(options), "environment": (GravityGradient(orbit), harmonic)}


def _harmonic(options: Options) -> HarmonicTorque:
    cosine, sine = (stacked(options, name)[None] for name in ("cosine", "sine"))
    return HarmonicTorque(options["rate"], cosine=cosine, sine=sine)


COMPENSATORS: dict[str, Component] = {
    "none": Component("No compensator.", {}, lambda options, controller, known, delay: controller),
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
            "attitude_sigma": positive(
                "angle", None, "Standard deviation of the star tracker about each body axis."
            ),
            "tracker_periods": Key(
                "1",
                1.0,
                "Control periods between star tracker samples, rounded to a whole number.",
                least=1.0,
            ),
            "angle_walk": positive("rad/√s", None, "Angle random walk of the gyro."),
            "bias_walk": size("rad/s/√s", 0.0, "Random walk of the gyro bias."),
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
            "coning_compensation": Key(
                "1",
                0.0,
                "Fraction of the coning for which the gyro compensates.",
                least=0.0,
                most=1.0,
            ),
            **_TACHOMETER,
        },
        _tracker_gyro,
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
}
ESTIMATOR_OF = {"white_noise": "none", "star_tracker_gyro": "kalman"}
"""Sensors -> estimator that they require."""
_EXTERNAL = {"external_torque": vector("torque", "Constant external torque, in body axes.")}
ORBIT = {
    "altitude": positive("m", None, "Altitude above the equatorial radius of the Earth."),
    "inclination": Key("angle", 0.0, "Inclination to the inertial x-y plane."),
    "ascending_node": Key("angle", 0.0, "Ascending node, from inertial x towards y."),
    "latitude": Key("angle", 0.0, "Initial argument of latitude, from the ascending node."),
}
ENVIRONMENTS: dict[str, Component] = {
    "constant": Component("Constant external torque.", _EXTERNAL, _constant_torque),
    "orbit": Component(
        "Circular Earth orbit: gravity gradient torque (`gyrostat.spacecraft.GravityGradient`), a "
        "constant torque and a torque with the period of the orbit "
        "(`gyrostat.spacecraft.HarmonicTorque`).",
        {
            **_EXTERNAL,
            **ORBIT,
            "cosine_torque": vector(
                "torque", "Amplitude of the torque cos(orbital rate × time), in body axes."
            ),
            "sine_torque": vector(
                "torque", "Amplitude of the torque sin(orbital rate × time), in body axes."
            ),
        },
        _in_orbit,
    ),
}
"""Kind -> external torques; `make` returns arguments of `gyrostat.spacecraft.Gyrostat`."""
TORQUES: dict[str, Component] = {
    "constant": Component(
        "Constant torque in body axes.",
        {"torque": vector("torque", "Torque, in body axes.")},
        lambda options, **given: HarmonicTorque(0.0, constant=stacked(options, "torque")),
    ),
    "gravity_gradient": Component(
        "Gravity gradient torque in a circular Earth orbit "
        "(`gyrostat.spacecraft.GravityGradient`).",
        ORBIT,
        lambda options, **given: GravityGradient(orbit_of(options)),
    ),
    "harmonic": Component(
        "Torque of one frequency in body axes (`gyrostat.spacecraft.HarmonicTorque`).",
        {
            "rate": positive("speed", None, "Angular frequency, such as that of the orbit."),
            "cosine": vector("torque", "Amplitude of cos(rate × time), in body axes."),
            "sine": vector("torque", "Amplitude of sin(rate × time), in body axes."),
        },
        lambda options, **given: _harmonic(options),
    ),
}
"""Kind -> external torque, any number of which can be added to the environment."""
