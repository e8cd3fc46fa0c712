"""Change of the torque that does not depend on the sense."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Offset(ChangeKind):
    """The offset changes, the other estimates do not."""

    name: ClassVar[str] = "offset"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(offset=1.0),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.03,), (0.1,), (0.3,))
    rate: ClassVar[float] = 0.01
