"""Vectors whose entries have names."""

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike


class NamedVector(np.ndarray):
    """Vector of real numbers whose entries can also be looked up by name.

    Results of arithmetic and slices are vectors without names.

    Attributes:
        names: Name of each entry; empty if the entries have no names.
    """

    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, names: Sequence[str], values: ArrayLike) -> Self:
        """Name the entries of a vector.

        Args:
            names: Names, (n,).
            values: Numbers, (n,).
        """
        vector = np.array(values, dtype=np.float64).view(cls)
        vector.names = tuple(names)
        return vector

    def __getitem__(self, key: Any) -> Any:
        """Return the entry of a name, or what NumPy returns for an index.

        Raises:
            KeyError: No entry has this name.
        """
        if not isinstance(key, str):
            return super().__getitem__(key)
        if key not in self.names:
            raise KeyError(f"found no {key!r}, expected one of {', '.join(self.names) or 'none'}")
        return float(super().__getitem__(self.names.index(key)))
