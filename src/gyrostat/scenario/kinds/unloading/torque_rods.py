"""Unloading of the wheels by torque rods."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.magnetic.rod_unloading import RodUnloading
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import Context, Kind, part_named
from gyrostat.scenario.schema import Key, positive, size, vector

MOMENTUM = vector("momentum", "Target of the wheels' momentum, in body axes.")
COMPENSATION = size(
    "1",
    0.0,
    "Share of the torque of the unloading that is added to the wheel torques; 0 for controllers "
    "that estimate external torques, such as `wheel_array`.",
    most=1.0,
)


@dataclass(frozen=True, eq=False)
class TorqueRodUnloading(Kind):
    """Unloading of the wheels by torque rods with the cross-product law.

    See `gyrostat.control.RodUnloading`. It needs a `[[sensor]]` named `magnetometer` and an
    `[[actuator]]` named `torque_rods`.
    """

    name = "torque_rods"
    needs = frozenset({part_named("sensor", "magnetometer"), part_named("actuator", "torque_rods")})
    limit: Annotated[
        Vector3,
        Key(
            "magnetic_dipole",
            None,
            "Largest commanded dipole moment of each rod.",
            least=0.0,
            shape=(3,),
        ),
    ]
    gain: Annotated[Scalar, positive("1/s", 1e-3, "Gain, slow compared with the attitude loop.")]
    momentum: Annotated[Vector3, MOMENTUM]
    duty: Annotated[
        Scalar,
        positive("1", 1.0, "Share of each control period in which the rods are on.", most=1.0),
    ]
    compensation: Annotated[Scalar, COMPENSATION]

    def make(self, context: Context) -> RodUnloading:
        """Controller with unloading."""
        assert context.spacecraft is not None
        return RodUnloading(context.controller, context.spacecraft.wheels, **self.options())
