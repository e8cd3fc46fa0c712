"""Base of the classes of change: how a fault shows in the observations."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.change.channels import CHANNELS


def direction(**parts: float) -> Vector:
    """Signature in the channels, (8,): name of a channel -> its part."""
    return np.array([parts.get(name, 0.0) for name in CHANNELS])


@dataclass(frozen=True)
class ChangeKind:
    """Class of change; a kind is a file with a subclass.

    The change is a sum of one or two signatures, whose sizes are independent and Gaussian.
    """

    name: ClassVar[str]
    """Name of the class."""
    signatures: ClassVar[tuple[Vector, ...]]
    """Signatures of unit size, one or two, each (8,)."""
    sizes: ClassVar[tuple[tuple[float, ...], ...]]
    """Standard deviations of the sizes: equally probable alternatives, one for each signature."""
    means: ClassVar[tuple[float, ...]] = (0.0, 0.0)
    """Means of the sizes, one for each signature; 0 where both directions are as probable."""
    rate: ClassVar[float]
    """Usual rate, faults per wheel-year: an assumption that the user can replace."""
    ramps: ClassVar[bool] = True
    """Whether the change may be slow; else it is a step."""
