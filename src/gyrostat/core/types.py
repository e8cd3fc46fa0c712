"""Types of NumPy arrays; `gyrostat.core.arrays` has those of traced (JAX) arrays."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""One-dimensional array of float64."""
Matrix = NDArray[np.float64]
"""Two-dimensional array of float64."""
