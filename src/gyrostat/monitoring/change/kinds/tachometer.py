"""Wrong scale of the measured speed."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Tachometer(ChangeKind):
    """All torques seem to be scaled alike, and the body rates contradict the speeds."""

    name: ClassVar[str] = "tachometer fault"
    signatures: ClassVar[tuple[Vector, ...]] = (
        direction(coulomb=1.0, motor_constant=1.0),
        direction(exchange=1.0),
    )
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.02, 0.1), (0.05, 0.5))
    rate: ClassVar[float] = 0.01
    ramps: ClassVar[bool] = False
