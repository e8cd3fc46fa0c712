"""Stiction: torque beyond Coulomb at zero crossings."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Stiction(ChangeKind):
    """The residual at crossings grows."""

    name: ClassVar[str] = "stiction"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(crossing=1.0),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.05,), (0.3,))
    means: ClassVar[tuple[float, ...]] = (0.1,)
    rate: ClassVar[float] = 0.01
    ramps: ClassVar[bool] = False
