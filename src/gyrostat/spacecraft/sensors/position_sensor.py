"""Position from satellite navigation."""

from typing import Annotated, Any

import equinox as eqx
from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.jax64 import jax
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.wheel.array import listed, zeros


class PositionSensor(Checked):
    """Measured position with bias and white noise, GCRS, (3,), m; for `Sampled`.

    Pointing at a target on the ground at a distance d, an error e across the line of sight turns
    the boresight by e / d.

    Attributes:
        orbit: Orbit.
        sigma: Standard deviation of the white noise of each axis, (3,), or one value for all, m.
        bias: Bias, GCRS, (3,), m.
    """

    orbit: OrbitEnvironment
    sigma: Annotated[Vector3 | Scalar, size("position sigma", "m")] = eqx.field(
        converter=listed, default=0.0
    )
    bias: Annotated[Vector3, signed("size of the position bias", "m")] = zeros()
    unit = "m"

    def __call__(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Vector3:
        """Measured position, (3,), m; see `InstantSensor`."""
        return self.orbit.position(time) + self.bias + self.sigma * jax.random.normal(key, (3,))
