"""Stiction: a breakaway torque beyond Coulomb."""

from typing import ClassVar

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind, direction


class Stiction(ChangeKind):
    """The largest torque at rest grows, the Coulomb torque does not."""

    name: ClassVar[str] = "stiction"
    signatures: ClassVar[tuple[Vector, ...]] = (direction(breakaway=1.0),)
    sizes: ClassVar[tuple[tuple[float, ...], ...]] = ((0.15,), (0.3,))
    means: ClassVar[tuple[float, ...]] = (0.4,)
    rate: ClassVar[float] = 0.01
    ramps: ClassVar[bool] = False
