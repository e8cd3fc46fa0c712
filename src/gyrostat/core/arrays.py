"""Types of traced (JAX) arrays used in many rooms; `gyrostat.core.types` has those of NumPy."""

from jaxtyping import Array, Float

Scalar = float | Float[Array, ""]
"""One real number."""
Vector3 = Float[Array, "3"]
"""Components along three axes."""
Quaternion = Float[Array, "4"]
"""Unit quaternion, scalar first."""
PerWheel = Float[Array, " wheels"]
"""One real number for each wheel."""
PerMode = Float[Array, " modes"]
"""One real number for each vibration mode."""
