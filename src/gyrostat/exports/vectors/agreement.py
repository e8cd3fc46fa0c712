"""Steps in which C and Python agree to rounding errors."""

from collections.abc import Sequence

import numpy as np

from gyrostat.codegen.flight.module import Precision
from gyrostat.exports.vectors.conditioning import Conditioning
from gyrostat.exports.vectors.fields import Field, arrays_of

CLOSE = {"double": 1e-13, "float": 1e-4}
"""Largest relative difference; a tenth of the tolerance of the test program."""
SHARE = 0.5
"""Share of the errors that rounding explains, which the test program allows too."""


class Agreement:
    """Comparison of results of C and Python.

    Attributes:
        results: Indices of the fields that are compared.
    """

    def __init__(
        self,
        fields: Sequence[Field],
        nominal: np.ndarray,
        precision: Precision,
        rounding: Conditioning,
    ) -> None:
        """Take the scales from the test run.

        Args:
            fields: Numbers of the module.
            nominal: Values of all fields after each step of the test run, (steps, fields).
            precision: Precision of real numbers in C.
            rounding: What rounding before each step of the test run changes.
        """
        self._close = CLOSE[precision]
        self.results = [k for k, field in enumerate(fields) if field.role in ("state", "output")]
        self._arrays = arrays_of([fields[k] for k in self.results])
        self._scale = np.zeros(len(self.results))
        largest = np.max(self._sizes(nominal[:, self.results]), axis=0)
        explained = SHARE * rounding.allowed(self.results, largest, self._close)
        self._scale = np.maximum(largest, explained / self._close)

    def _sizes(self, values: np.ndarray) -> np.ndarray:
        """Sizes of finite values, at least a share of the largest one in their array."""
        sizes = np.where(np.isfinite(values), np.abs(values), 0.0)
        for places in self._arrays:
            whole = np.max(sizes[:, places], axis=1, keepdims=True)
            sizes[:, places] = np.maximum(sizes[:, places], 0.005 * whole)
        return np.maximum(sizes, self._scale)

    def agree(self, code: np.ndarray, python: np.ndarray) -> np.ndarray:
        """Whether the results of C and Python agree after each step; both (steps, fields).

        A condition close to its limit may be decided by the last digit, in which elementary
        functions of Python and C differ.
        """
        ours, theirs = code[:, self.results], python[:, self.results]
        with np.errstate(all="ignore"):
            close = np.abs(ours - theirs) <= self._close * self._sizes(theirs)
        return np.all((ours == theirs) | (np.isnan(ours) & np.isnan(theirs)) | close, axis=1)
