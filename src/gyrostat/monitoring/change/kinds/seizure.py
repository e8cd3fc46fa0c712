"""Drag that stops the wheel."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Seizure(ChangeKind):
    """The Coulomb torque multiplies, and the wheel stands still."""

    name: ClassVar[str] = "seizure"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(coulomb=1.0), direction(standstill=1.0))
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((3.0, 0.5), (30.0, 0.5))
    rate: ClassVar[float] = 0.005
