"""Three-axis magnetometer."""

from typing import Annotated, Any

import equinox as eqx
from jaxtyping import PRNGKeyArray

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, to_body
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.wheel.array import listed, zeros


class Magnetometer(Checked):
    """Measured magnetic flux density (1 + k) M B + b + noise, for `Sampled`.

    B is the Earth's field in body axes, M the rotation from body to magnetometer axes, k the scale
    factor error and b the bias of each axis. The dipole of torque rods is not measured: they are
    off during a sample, see `TorqueRods`. The static field of the spacecraft is part of the bias.

    Attributes:
        orbit: Orbit with the magnetic field.
        sigma: Standard deviation of the white noise of each axis, (3,), or one value for all, T.
        bias: Bias, (3,), T.
        scale_factor: Scale factor error of each axis, (3,), 1.
        misalignment: Rotation vector from body axes to magnetometer axes, (3,), rad.
    """

    orbit: OrbitEnvironment
    sigma: Annotated[Vector3 | Scalar, size("magnetometer sigma", "T")] = eqx.field(
        converter=listed, default=0.0
    )
    bias: Annotated[Vector3, signed("size of the magnetometer bias", "T")] = zeros()
    scale_factor: Annotated[Vector3, signed("size of the magnetometer scale factor")] = zeros()
    misalignment: Annotated[Vector3, signed("size of the magnetometer misalignment", "rad")] = (
        zeros()
    )
    unit = "T"

    def __call__(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Vector3:
        """Measured flux density in body axes, (3,), T; see `InstantSensor`."""
        field = to_body(state.attitude, self.orbit.field(time))
        mounted = to_body(from_rotation_vector(jnp.asarray(self.misalignment)), field)
        noise = self.sigma * jax.random.normal(key, (3,))
        return (1.0 + jnp.asarray(self.scale_factor)) * mounted + self.bias + noise
