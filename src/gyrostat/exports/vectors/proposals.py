"""Values to try for fields."""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.exports.vectors.fields import Field, arrays_of

_REALS = np.array(
    [
        *(0.0, -0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 1e-300, -1e-300, 1e-30, 1e300, -1e300),
        *(1e-6, -1e-6, 1e-3, -1e-3, 0.1, -0.1, 10.0, -10.0, 1e3, -1e3, 1e6, -1e6, 1e12, -1e12),
        *(1e38, -1e38, 1e150, -1e150, 0.5, -0.5, 2.0, -2.0, np.pi, -np.pi, 1.7e308, -1.7e308),
        *(3.4e38, -3.4e38),
    ]
)
_INTEGERS = (0, 1, 2, 3, 4, 5, -1, 10, 100, 1000, 2**31 - 1)
SPECIAL = {"real": (np.nan, np.inf), "integer": (-(2.0**31) - 1.0, 2.0**31)}
"""Kind of a number -> values beyond all ordinary ones. An index narrows to 32 bits, so that such
integers change their sign between a test of the number and a test of the index."""


class Proposals:
    """Random values for fields, from values that conditions often compare with."""

    def __init__(
        self, fields: Sequence[Field], limits: Mapping[int, Sequence[int | float]]
    ) -> None:
        """Begin with a fixed seed.

        Args:
            fields: Numbers of the module.
            limits: Field -> other fields, as their indices, and numbers that it is compared with.
        """
        self._limits = limits
        self.random = np.random.default_rng(0)
        self._fields = fields
        self._array = {k: array for array in arrays_of(fields) for k in array}

    def change(self, values: np.ndarray, free: Sequence[int], count: int) -> list[int]:
        """Change some fields, or whole arrays, at random.

        Args:
            values: Values of all fields, which change in place.
            free: Fields that may be changed.
            count: Number of fields or arrays.

        Returns:
            The fields that were changed.
        """
        changed: list[int] = []
        allowed = set(free)
        for k in self.random.choice(free, min(count, len(free)), replace=False).tolist():
            array = [each for each in self._array[k] if each in allowed]
            if len(array) > 1 and self.random.integers(4) == 0:
                self._change_array(values, array)
                changed += array
            else:
                values[k] = self.value(k, values)
                changed.append(k)
        return changed

    def _change_array(self, values: np.ndarray, array: list[int]) -> None:
        if self._fields[array[0]].kind != "real":
            values[array] = self.value(array[0], values)
            return
        match self.random.integers(3):
            case 0:
                values[array] = self.random.choice(_REALS)
            case 1:
                with np.errstate(over="ignore"):
                    values[array] *= self.random.choice([-1.0, 1e-12, 1e12, 1e-3, 1e3])
            case _:
                values[array] = self.random.normal(size=len(array))

    def value(self, index: int, values: np.ndarray) -> float:
        """Value to try for a field: one that it is compared with, a special or a similar one."""
        random, value = self.random, float(values[index])
        kind, limits = self._fields[index].kind, self._limits.get(index, ())
        if kind == "logical":
            return 1.0 - value
        if limits and random.integers(3) == 0:
            limit = limits[int(random.integers(len(limits)))]
            limit = float(values[limit]) if isinstance(limit, int) else limit
            limit *= float(random.choice([1.0, 1.0, -1.0]))
            if kind == "integer":
                return limit + float(random.choice([-1.0, 0.0, 1.0]))
            return float(np.nextafter(limit, random.choice([-np.inf, limit, np.inf])))
        if kind == "integer":
            return float(random.choice(np.array([value + 1, value - 1, *_INTEGERS])))
        finite = value if np.isfinite(value) else 1.0
        match random.integers(7):
            case 0 | 1:
                return float(random.choice(_REALS))
            case 2:
                return float(values[random.integers(len(values))])
            case 3:
                return -value
            case 4:
                return finite * 10.0 ** random.uniform(-3.0, 3.0)
            case 5:
                other = float(values[random.integers(len(values))])
                return finite + (other if np.isfinite(other) else 1.0) * random.normal()
        return finite + max(abs(finite), 1e-3) * random.normal()
