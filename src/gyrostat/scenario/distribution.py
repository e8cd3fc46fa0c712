"""Base of the distributions of dispersed values, whose classes are in kinds/dispersion."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.annotations import notes_of
from gyrostat.core.orthonormal import HERMITE, Family, family_of
from gyrostat.core.types import Matrix, Vector

VALUE, DEVIATION, RATIO = "value", "deviation", "ratio"


class Parameter(NamedTuple):
    """Parameter of a distribution, the annotation of a field.

    Attributes:
        of: `VALUE`, in a file also its relative difference from the nominal value, "-10 %";
            `DEVIATION` from the nominal value, in a file also relative to it, "20 %"; or `RATIO`.
        meaning: Meaning, for the documentation.
        default: Value where a file has none; NaN: the nominal value. None: it is required.
    """

    of: str
    meaning: str
    default: float | None = None


@dataclass(frozen=True, eq=False)
class Distribution:
    """Distribution of values that are drawn for each run, of all of them at once.

    The fields of a subclass are its parameters, `Annotated[Vector, Parameter(...)]`, in the order
    in which `Dispersion.parameters` has them.

    Attributes:
        nominal: Nominal values, (keys,), SI.
        name: Name in scenario files.
        family: Orthonormal polynomials of every value; None: those of its quantile function.
    """

    nominal: Vector
    name: ClassVar[str]
    family: ClassVar[Family | None] = None

    @classmethod
    def parameters(cls) -> dict[str, Parameter]:
        """Parameters by name."""
        return notes_of(cls, Parameter)

    @classmethod
    def of(cls, nominal: Vector, rows: Matrix) -> Self:
        """Distribution with the parameters of each value as a row, (keys, parameters)."""
        return cls(nominal, *rows.T)

    def quantile(self, share: Matrix) -> Matrix:
        """Values, (n, keys), SI, of independent uniform numbers between 0 and 1, (n, keys)."""
        raise NotImplementedError

    def families(self) -> list[Family]:
        """Orthonormal polynomials of the variable behind each uniform number, (keys,)."""
        if self.family is not None:
            return [self.family] * len(self.nominal)
        bounded = self.is_bounded()
        return [family_of(self._quantile_of(k), is_bounded=bool(b)) for k, b in enumerate(bounded)]

    def _quantile_of(self, key: int) -> Callable[[Vector], Vector]:
        """Quantile function of one value."""
        return lambda share: self.quantile(np.outer(share, np.ones_like(self.nominal)))[:, key]

    def faults(self) -> Iterator[tuple[str, str]]:
        """Parameters that cannot be, each with what is expected."""
        yield from ()

    def bounds(self) -> tuple[Vector, Vector]:
        """Smallest and largest possible values, each (keys,)."""
        return np.full_like(self.nominal, -np.inf), np.full_like(self.nominal, np.inf)

    def is_bounded(self) -> NDArray[np.bool_]:
        """Whether a value has a smallest and a largest value, (keys,)."""
        low, high = self.bounds()
        return np.isfinite(low) & np.isfinite(high)

    def deviation(self) -> Vector:
        """Standard deviation of each value, (keys,); NaN if it is no parameter."""
        return np.full_like(self.nominal, np.nan)

    def extremes(self, sigmas: float) -> tuple[Vector, Vector]:
        """Bounds of each value; where it has none, its quantile of Φ(∓ `sigmas`)."""
        from scipy.special import ndtr  # slow to import

        tail = np.full((1, len(self.nominal)), float(ndtr(-sigmas)))
        ends = self.quantile(tail)[0], self.quantile(1.0 - tail)[0]
        low, high = (
            np.where(np.isfinite(bound), bound, end)
            for bound, end in zip(self.bounds(), ends, strict=True)
        )
        return low, high

    def is_joint(self) -> bool:
        """Whether the values depend on each other."""
        return False


class Limited(Distribution):
    """Distribution with the parameters `low` and `high`."""

    low: Vector
    high: Vector

    def faults(self) -> Iterator[tuple[str, str]]:
        """See `Distribution.faults`."""
        if not np.all(self.low < self.high):
            yield "high", "more than low"

    def bounds(self) -> tuple[Vector, Vector]:
        """See `Distribution.bounds`."""
        return self.low, self.high


class Correlated(Distribution):
    """Distribution of values that depend on each other by normal numbers.

    Attributes:
        root: Matrix from independent standard normal numbers to those of the values, (keys, keys).
    """

    family = HERMITE
    root: Matrix

    def normal(self, share: Matrix) -> Matrix:
        """Normal numbers of the values, (n, keys), from uniform numbers; see `quantile`."""
        from scipy.special import ndtri  # slow to import

        independent = ndtri(share)
        numbers = np.zeros_like(share)
        # fixed order of summation: the rounding of a matrix product may depend on the number of
        # rows
        for k, column in enumerate(self.root.T):
            numbers += independent[:, k, None] * column
        return numbers

    def is_joint(self) -> bool:
        """See `Distribution.is_joint`."""
        return bool(np.any(self.root != np.diag(np.diag(self.root))))
