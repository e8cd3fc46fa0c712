"""Imbalance of the wheels of a scenario, with harmonics and structural modes."""

from functools import partial

from gyrostat.core.jax64 import jnp
from gyrostat.scenario.build_spacecraft import has_section, of_wheels
from gyrostat.scenario.scenario import AXES
from gyrostat.scenario.sensing import Values
from gyrostat.scenario.structure import Structure
from gyrostat.spacecraft import Imbalance, WheelHarmonics, WheelStructure


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
    per_wheel = partial(of_wheels, structure, values)
    modes = None
    if has_section(structure, "rocking_frequency"):
        modes = WheelStructure(
            2.0 * jnp.pi * per_wheel("radial_frequency"),
            per_wheel("radial_damping"),
            2.0 * jnp.pi * per_wheel("rocking_frequency"),
            per_wheel("rocking_damping"),
            per_wheel("inertia_ratio"),
        )
    return Imbalance(
        per_wheel("static_imbalance"),
        per_wheel("dynamic_imbalance"),
        jnp.stack([per_wheel(f"position.{axis}") for axis in AXES]),
        WheelHarmonics.joined(*harmonics) if harmonics else None,
        modes,
    )
