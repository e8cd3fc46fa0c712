"""Base of the appendages of a spacecraft file, whose classes are in kinds/appendage."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import Kind
from gyrostat.scenario.schema import positive, size
from gyrostat.spacecraft import FlexibleModes, Spacecraft
from gyrostat.spacecraft.flexible.appendages import appendage_modes


@dataclass(frozen=True, eq=False)
class AppendageKind(Kind):
    """Flexible appendage or propellant; its name is that of its tables in a spacecraft file."""

    frequency: Annotated[Scalar, positive("frequency", None, "Frequency on a body at rest.")]
    damping: Annotated[Scalar, size("1", 0.0, "Damping ratio on a body at rest.")]

    @classmethod
    def modes(cls, values: Mapping[str, Scalar], spacecraft: Spacecraft) -> FlexibleModes:
        """Modes of the appendage.

        Args:
            values: Key -> value, a number for each component, SI.
            spacecraft: Spacecraft of the run.
        """
        return appendage_modes(cls.name, values, spacecraft)
