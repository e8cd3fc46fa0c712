"""Last samples of a signal that arrives in parts."""

import numpy as np
from jaxtyping import Float
from numpy.typing import NDArray


class Recent:
    """Last samples of several runs; memory and time do not depend on the number of samples.

    Args:
        runs: Number of runs.
        length: Number of samples that are available before the newest part.
        size: Number of components of a sample.
    """

    def __init__(self, runs: int, length: int, size: int):
        self._length, self._end = length, length
        self._values: NDArray[np.float64] = np.zeros((runs, 2 * length + 1, size))

    def add(self, part: Float[np.ndarray, "runs samples size"]) -> None:
        """Add the next samples."""
        count, room = part.shape[1], self._values.shape[1]
        if self._end + count > room:
            tail = self._values[:, self._end - self._length : self._end].copy()
            if self._length + count > room:
                shape = (len(tail), 2 * (self._length + count), tail.shape[2])
                self._values = np.zeros(shape)
            self._values[:, : self._length] = tail
            self._end = self._length
        self._values[:, self._end : self._end + count] = part
        self._end += count

    def back(self, samples: int, count: int) -> Float[np.ndarray, "runs count size"]:
        """View of `count` samples that ended a number of samples before the newest one."""
        end = self._end - samples
        return self._values[:, end - count : end]
