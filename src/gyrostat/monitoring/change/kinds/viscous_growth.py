"""Change of the viscous coefficient."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class ViscousGrowth(ChangeKind):
    """The viscous coefficient changes, the other estimates do not."""

    name: ClassVar[str] = "viscous growth"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(viscous=1.0),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.05,), (0.2,), (0.6,))
    rate: ClassVar[float] = 0.02
