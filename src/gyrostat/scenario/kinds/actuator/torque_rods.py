"""Magnetic torque rods."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.rotations import from_rotation_vector, rotation_matrix
from gyrostat.scenario.component import ORBIT, Context, Kind
from gyrostat.scenario.schema import Key, positive, vector
from gyrostat.spacecraft.actuators.torque_rods import TorqueRods


@dataclass(frozen=True, eq=False)
class TorqueRodsKind(Kind):
    """Three magnetic torque rods along the body axes (`gyrostat.spacecraft.TorqueRods`).

    The command is the dipole moment of each rod, A·m².
    """

    name = "torque_rods"
    needs = frozenset({ORBIT})
    limit: Annotated[
        Vector3,
        Key("magnetic_dipole", None, "Largest dipole moment of each rod.", least=0.0, shape=(3,)),
    ]
    duty: Annotated[
        Scalar,
        positive(
            "1",
            1.0,
            "Share of each control period in which the rods are on; the magnetometer measures in "
            "the rest.",
            most=1.0,
        ),
    ]
    misalignment: Annotated[
        Vector3,
        vector(
            "angle", "Rotation vector from body axes to those of the rods.", source="misalignment"
        ),
    ]

    def make(self, context: Context) -> TorqueRods:
        """Actuator."""
        assert context.orbit is not None
        axes = rotation_matrix(from_rotation_vector(self.misalignment))
        return TorqueRods(context.orbit, self.limit, axes, self.duty)
