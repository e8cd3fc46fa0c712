"""Change of the motor constant."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class MotorConstant(ChangeKind):
    """The motor constant changes, the other estimates do not."""

    name: ClassVar[str] = "motor constant"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(motor_constant=1.0, breakaway=-1.0),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.01,), (0.03,), (0.1,))
    rate: ClassVar[float] = 0.005
