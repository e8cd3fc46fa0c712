"""Environments and external torques that a scenario can name, one entry each."""

from math import pi
from typing import Any

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.spacecraft import (
    AerodynamicTorque,
    CircularOrbit,
    GravityGradient,
    HarmonicTorque,
    ResidualDipole,
    SolarPressureTorque,
)
from gyrostat.spacecraft.environment import EARTH, EARTH_RADIUS


def _constant_torque(options: Options) -> dict[str, Any]:
    return {"external_torque": options["external_torque"]}


def orbit_of(options: Options) -> CircularOrbit:
    """Circular orbit from the values of the keys `ORBIT`."""
    rate = jnp.sqrt(EARTH / (EARTH_RADIUS + options["altitude"]) ** 3)
    names = ("inclination", "ascending_node", "latitude")
    return CircularOrbit(rate, **{name: options[name] for name in names})


def _in_orbit(options: Options) -> dict[str, Any]:
    orbit = orbit_of(options)
    harmonic = HarmonicTorque(
        orbit.rate,
        cosine=options["cosine_torque"][None],
        sine=options["sine_torque"][None],
    )
    return {**_constant_torque(options), "environment": (GravityGradient(orbit), harmonic)}


def environment_torques(made: dict[str, Any]) -> dict[str, Any]:
    """Name -> environment torque of the section [environment], from the result of its `make`."""
    found = {"constant": HarmonicTorque(0.0, constant=made["external_torque"])}
    names = ("gravity_gradient", "harmonic")
    return found | dict(zip(names, made.get("environment", ()), strict=False))


def _harmonic(options: Options, **given: Any) -> HarmonicTorque:
    cosine, sine = options["cosine"][None], options["sine"][None]
    return HarmonicTorque(options["rate"], cosine=cosine, sine=sine)


_EXTERNAL = {"external_torque": vector("torque", "Constant external torque, in body axes.")}
ORBIT = {
    "altitude": positive("length", None, "Altitude above the equatorial radius of the Earth."),
    "inclination": size("angle", 0.0, "Inclination to the inertial x-y plane.", most=pi),
    "ascending_node": Key("angle", 0.0, "Ascending node, from inertial x towards y."),
    "latitude": Key("angle", 0.0, "Initial argument of latitude, from the ascending node."),
}
EITHER_ORBIT: dict[str, Key] = {
    **ORBIT,
    "altitude": size(
        "length",
        0.0,
        "Altitude above the equatorial radius of the Earth, of a circular orbit; required without "
        "[orbit], and not allowed with it.",
    ),
}
"""Keys of a component that follows the tables of [orbit], or a circular orbit of its own."""
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
        lambda options, **given: HarmonicTorque(0.0, constant=options["torque"]),
    ),
    "gravity_gradient": Component(
        "Gravity gradient torque along [orbit], or in a circular Earth orbit "
        "(`gyrostat.spacecraft.GravityGradient`).",
        EITHER_ORBIT,
        lambda options, orbit, **given: GravityGradient(orbit or orbit_of(options)),
    ),
    "harmonic": Component(
        "Torque of one frequency in body axes (`gyrostat.spacecraft.HarmonicTorque`).",
        {
            "rate": positive("speed", None, "Angular frequency, such as that of the orbit."),
            "cosine": vector("torque", "Amplitude of cos(rate × time), in body axes."),
            "sine": vector("torque", "Amplitude of sin(rate × time), in body axes."),
        },
        _harmonic,
    ),
    "residual_dipole": Component(
        "Torque of the magnetic field of the Earth on a residual dipole moment "
        "(`gyrostat.spacecraft.ResidualDipole`).",
        {"dipole": vector("magnetic_dipole", "Residual dipole moment, in body axes.")},
        lambda options, orbit, **given: ResidualDipole(orbit, **options),
        needs=("orbit",),
    ),
    "aerodynamic": Component(
        "Air drag on the surfaces of the spacecraft (`gyrostat.spacecraft.AerodynamicTorque`).",
        {
            "drag_coefficient": positive("1", 2.2, "Drag coefficient of every facet."),
            "density_scale": size("1", 1.0, "Factor on the air density."),
        },
        lambda options, orbit, **given: AerodynamicTorque(orbit, **options),
        needs=("orbit", "surfaces"),
    ),
    "solar_pressure": Component(
        "Solar radiation pressure on the surfaces of the spacecraft, with eclipses "
        "(`gyrostat.spacecraft.SolarPressureTorque`).",
        {"scale": size("1", 1.0, "Factor on the pressure.")},
        lambda options, orbit, **given: SolarPressureTorque(orbit, **options),
        needs=("orbit", "surfaces"),
    ),
}
"""Kind -> external torque, any number of which can be added to the environment."""
