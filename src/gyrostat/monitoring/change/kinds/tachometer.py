"""Wrong scale of the measured speed."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Tachometer(ChangeKind):
    """All torques seem to be scaled alike, and so does the momentum that the body receives."""

    name: ClassVar[str] = "tachometer fault"
    signatures: ClassVar[tuple[Vector, ...]] = (
        direction(coulomb=1.0, motor_constant=1.0, speed_scale=-1.0),
    )
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.01,), (0.03,), (0.1,))
    rate: ClassVar[float] = 0.01
    ramps: ClassVar[bool] = False
