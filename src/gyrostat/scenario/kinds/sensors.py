"""Further sensors and star tracker heads that a scenario can name, one entry each."""

from collections.abc import Callable
from math import inf, pi
from typing import Any

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.spacecraft import PaddleAngle, Spacecraft
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.sensors.magnetometer import Magnetometer
from gyrostat.spacecraft.sensors.position_sensor import PositionSensor
from gyrostat.spacecraft.sensors.sampled import LONGEST, Sampled
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHead
from gyrostat.spacecraft.sensors.sun_sensor import FACES, CoarseSunSensors, SunSensor

_SAMPLING = {
    "periods": Key(
        "1", 1.0, "Control periods between samples, rounded to a whole number.", least=1.0
    ),
    "latency": size(
        "1",
        0.0,
        "Control periods from a sample to its use, rounded to a whole number.",
        most=float(LONGEST),
    ),
}
_ORBIT = ("orbit",)


def _sampled(sensor: Callable[..., Any]) -> Callable[..., Sampled]:
    """Function that makes a sensor of the options with the names of its fields, and samples it."""

    def make(options: Options, orbit: OrbitEnvironment, **given: Any) -> Sampled:
        own = {name: value for name, value in options.items() if name not in _SAMPLING}
        periods, latency = jnp.round(options["periods"]), jnp.round(options["latency"])
        return Sampled(sensor(orbit, **own), periods, latency)

    return make


def _paddle_angle(options: Options, spacecraft: Spacecraft, **given: Any) -> PaddleAngle:
    return PaddleAngle(spacecraft.wheels.count - 1, options["sigma"])


def _head(options: Options, orbit: OrbitEnvironment, **given: Any) -> StarTrackerHead:
    own = dict(options)
    return StarTrackerHead(orbit, own.pop("across_sigma"), own.pop("about_sigma"), **own)


_BORESIGHT = vector("1", "Boresight in body axes, of any length.", (0.0, 0.0, 1.0))
FURTHER_SENSORS: dict[str, Component] = {
    "magnetometer": Component(
        "Magnetic flux density in body axes, (3,) (`gyrostat.spacecraft.Magnetometer`).",
        {
            "sigma": size("flux_density", 0.0, "Standard deviation of the noise of each axis."),
            "bias": vector("flux_density", "Bias, in body axes."),
            "scale_factor": vector("1", "Scale factor error of each axis."),
            "misalignment": vector("angle", "Rotation vector from body to magnetometer axes."),
            **_SAMPLING,
        },
        _sampled(Magnetometer),
        unit="T",
        needs=_ORBIT,
    ),
    "sun_sensor": Component(
        "Direction of the Sun in body axes, (3,), zero if it is not seen "
        "(`gyrostat.spacecraft.SunSensor`).",
        {
            "sigma": size("angle", 0.0, "Standard deviation of the error about each axis."),
            "misalignment": vector("angle", "Rotation vector from body to sensor axes."),
            "boresight": _BORESIGHT,
            "field_of_view": positive(
                "angle", pi, "Largest angle between boresight and Sun.", most=pi
            ),
            **_SAMPLING,
        },
        _sampled(SunSensor),
        needs=_ORBIT,
    ),
    "coarse_sun_sensors": Component(
        "Currents of six sun cells on the faces +x, -x, +y, -y, +z, -z, (6,), 1 at normal "
        "incidence (`gyrostat.spacecraft.CoarseSunSensors`). Albedo is not "
        "modelled.",
        {
            "sigma": size("1", 0.0, "Standard deviation of the noise of each cell."),
            "scale_factor": Key(
                "1", 0.0, "Relative error of the current of each cell.", shape=(len(FACES),)
            ),
            **_SAMPLING,
        },
        _sampled(CoarseSunSensors),
        needs=_ORBIT,
    ),
    "paddle_angle": Component(
        "Angle of the paddle of the controller `two_wheels_paddle`, a number "
        "(`gyrostat.spacecraft.PaddleAngle`).",
        {"sigma": size("angle", 0.0, "Standard deviation of the noise.")},
        _paddle_angle,
        unit="rad",
        needs=("paddle",),
    ),
    "position": Component(
        "Position from satellite navigation, GCRS, (3,) (`gyrostat.spacecraft.PositionSensor`).",
        {
            "sigma": size("length", 0.0, "Standard deviation of the noise of each axis."),
            "bias": vector("length", "Bias, GCRS."),
            **_SAMPLING,
        },
        _sampled(PositionSensor),
        unit="m",
        needs=_ORBIT,
    ),
}
"""Kind of [[sensor]] -> component."""
HEADS: dict[str, Component] = {
    "head": Component(
        "Head of the star tracker of the sensors `star_tracker_gyro` or `star_tracker` "
        "(`gyrostat.spacecraft.StarTrackerHead`).",
        {
            "across_sigma": positive(
                "angle", None, "Standard deviation about each axis across the boresight."
            ),
            "about_sigma": positive("angle", None, "Standard deviation about the boresight."),
            "boresight": _BORESIGHT,
            "misalignment": vector("angle", "Constant rotation of the measured attitude."),
            "sun_exclusion": size("angle", 0.0, "Smallest angle between boresight and Sun."),
            "earth_exclusion": size(
                "angle", 0.0, "Smallest angle between boresight and limb of the Earth."
            ),
            "rate_limit": positive("speed", inf, "Largest body rate."),
        },
        _head,
        needs=_ORBIT,
    ),
}
"""Kind of [[star_tracker]] -> component."""
