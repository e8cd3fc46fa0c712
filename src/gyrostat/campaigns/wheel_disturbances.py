"""Disturbances of the wheels of a scenario: imbalance, harmonics and structural modes."""

from typing import Any

from gyrostat.campaigns.build_spacecraft import has_section, of_wheels
from gyrostat.campaigns.components import Component, Options
from gyrostat.campaigns.scenario import AXES
from gyrostat.campaigns.schema import Key, positive, size
from gyrostat.campaigns.sensing import Values
from gyrostat.campaigns.structure import Structure
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import Imbalance, WheelHarmonics, WheelStructure


def _harmonic(options: Options, *, wheels: int, **given: Any) -> WheelHarmonics:
    return WheelHarmonics.single(wheels=wheels, **options)


HARMONICS: dict[str, Component] = {
    "harmonic": Component(
        "Forces and torque of every wheel at a multiple of the wheel speed "
        "(`gyrostat.spacecraft.WheelHarmonics`).",
        {
            "number": positive("1", None, "Multiple of the wheel speed; any positive number."),
            "force": size("imbalance", 0.0, "Radial force over the squared wheel speed."),
            "torque": size("inertia", 0.0, "Torque across the axis over the squared wheel speed."),
            "axial": size("imbalance", 0.0, "Axial force over the squared wheel speed."),
            "phase": Key("angle", 0.0, "Phase at the rotor angle 0."),
        },
        _harmonic,
    ),
}
"""Kind of [[imbalance.harmonic]] -> component."""


def imbalance_of(
    structure: Structure, values: Values, harmonics: list[WheelHarmonics]
) -> Imbalance | None:
    """Imbalance of the wheels of a run; None for balanced wheels.

    Args:
        structure: Structure of the scenario.
        values: Values of this run.
        harmonics: Harmonics of the scenario.
    """
    if not has_section(structure, "static_imbalance"):
        return None

    def each(name: str) -> Any:
        return of_wheels(structure, values, name)

    modes = None
    if has_section(structure, "rocking_frequency"):
        modes = WheelStructure(
            2.0 * jnp.pi * each("radial_frequency"),
            each("radial_damping"),
            2.0 * jnp.pi * each("rocking_frequency"),
            each("rocking_damping"),
            each("inertia_ratio"),
        )
    return Imbalance(
        each("static_imbalance"),
        each("dynamic_imbalance"),
        jnp.stack([each(f"position.{axis}") for axis in AXES]),
        WheelHarmonics.joined(*harmonics) if harmonics else None,
        modes,
    )
