"""Disturbances of the wheels of a scenario: imbalance, harmonics and structural modes."""

from typing import Any

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.build_spacecraft import has_section, of_wheels
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.scenario import AXES
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.scenario.sensing import Values
from gyrostat.scenario.structure import Structure
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
