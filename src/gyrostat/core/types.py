"""Array types that every module names alike."""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
"""One axis of real numbers."""
Matrix = NDArray[np.float64]
"""Two axes of real numbers."""
