"""Change of the Coulomb torque."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class CoulombGrowth(ChangeKind):
    """The Coulomb torque changes, the other estimates do not; the breakaway torque follows."""

    name: ClassVar[str] = "Coulomb growth"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(coulomb=1.0, breakaway=0.8),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.03,), (0.1,), (0.3,))
    rate: ClassVar[float] = 0.03
