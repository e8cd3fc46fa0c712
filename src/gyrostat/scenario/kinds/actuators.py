"""Actuators that a scenario can name, one entry each."""

from typing import Any

from gyrostat.core.arrays import Scalar
from gyrostat.core.rotations import from_rotation_vector, rotation_matrix
from gyrostat.scenario.kinds.components import Component, Options
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.spacecraft.actuators.thrusters import Thrusters
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment

DIPOLE_LIMIT = Key(
    "magnetic_dipole", None, "Largest dipole moment of each rod.", least=0.0, shape=(3,)
)
DUTY = positive(
    "1",
    1.0,
    "Share of each control period in which the rods are on; the magnetometer measures in the rest.",
    most=1.0,
)

THRUSTERS = {
    "arm": positive("length", None, "Distance of each thruster from the centre of mass."),
    "force": positive("N", None, "Thrust of each thruster."),
    "minimum": size(
        "time",
        0.0,
        "Minimum on-time: minimum impulse bit over thrust; a shorter command does nothing.",
    ),
}


def _torque_rods(options: Options, orbit: OrbitEnvironment, **given: Any) -> TorqueRods:
    axes = rotation_matrix(from_rotation_vector(options["misalignment"]))
    return TorqueRods(orbit, options["limit"], axes, options["duty"])


def _thrusters(options: Options, period: Scalar, **given: Any) -> Thrusters:
    return Thrusters.couples(options["arm"], options["force"], period, minimum=options["minimum"])


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
    "thrusters": Component(
        "Twelve thrusters in six pairs without net force, about +x, -x, +y, -y, +z and -z "
        "(`gyrostat.spacecraft.Thrusters`), for `[unloading]` or a controller of your own. The "
        "command is the on-time of each thruster in the control period, s, in the order of the "
        "pairs.",
        THRUSTERS,
        _thrusters,
    ),
}
"""Kind of [[actuator]] -> component."""
