"""Torque bursts of an unstable cage."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class TorqueBursts(ChangeKind):
    """Residuals grow for minutes, and the mean Coulomb torque with them."""

    name: ClassVar[str] = "torque bursts"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(burst=1.0), direction(coulomb=1.0))
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.5, 0.02), (0.5, 0.1))
    means: ClassVar[tuple[float, ...]] = (1.2, 0.0)
    rate: ClassVar[float] = 0.03
    ramps: ClassVar[bool] = False
