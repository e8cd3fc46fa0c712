"""Base of the environments that a scenario can name, whose classes are in kinds/environment."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrostat.core.arrays import Vector3
from gyrostat.scenario.component import Kind
from gyrostat.scenario.schema import vector
from gyrostat.spacecraft import TorqueModel


@dataclass(frozen=True, eq=False)
class EnvironmentKind(Kind):
    """External torques of the whole run.

    Attributes:
        torque_names: Names of the torques beside the constant one, in the momentum budget.
    """

    torque_names: ClassVar[tuple[str, ...]] = ()
    external_torque: Annotated[
        Vector3,
        vector("torque", "Constant external torque, in body axes.", source="external torque"),
    ]

    def torques(self) -> tuple[TorqueModel, ...]:
        """Torques beside the constant one, in the order of their names."""
        return ()
