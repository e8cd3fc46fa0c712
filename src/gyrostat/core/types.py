"""Types of NumPy arrays; `gyrostat.core.arrays` has those of traced arrays."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""One axis of real numbers."""
Matrix = NDArray[np.float64]
"""Two axes of real numbers."""
