"""Actuators that a scenario can name, one entry each."""

from typing import Any

from gyrostat.campaigns.components import Component, Options, stacked
from gyrostat.campaigns.schema import Key, vector
from gyrostat.core.rotations import from_rotation_vector, rotation_matrix
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

DIPOLE_LIMIT = Key(
    "magnetic_dipole", None, "Largest dipole moment of each rod.", least=0.0, shape=(3,)
)
DUTY = Key(
    "1",
    1.0,
    "Share of each control period in which the rods are on; the magnetometer measures in the rest.",
    least=0.0,
    most=1.0,
    positive=True,
)


def _torque_rods(options: Options, orbit: OrbitEnvironment, **given: Any) -> TorqueRods:
    axes = rotation_matrix(from_rotation_vector(stacked(options, "misalignment")))
    return TorqueRods(orbit, stacked(options, "limit"), axes, options["duty"])


ACTUATORS: dict[str, Component] = {
    "torque_rods": Component(
        "Three magnetic torque rods along the body axes "
        "(`gyrostat.spacecraft.TorqueRods`). The command is the dipole "
        "moment of each rod, A·m².",
        {
            "limit": DIPOLE_LIMIT,
            "duty": DUTY,
            "misalignment": vector("angle", "Rotation vector from body axes to those of the rods."),
        },
        _torque_rods,
        needs=("orbit",),
    ),
}
"""Kind of [[actuator]] -> component."""
