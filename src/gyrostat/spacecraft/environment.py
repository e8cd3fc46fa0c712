"""Gravity gradient and periodic torques on a spacecraft, for `Gyrostat.environment`.

A torque model is a callable (spacecraft, attitude, time in s) -> torque in body axes, (3,), N·m.
The total momentum of a gyrostat is the integral of the sum of these torques; the wheels do not
change it.
"""

from typing import Annotated

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, signed, size, within
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.core.validation import require
from gyrostat.spacecraft.orbit.earth import EARTH, EARTH_RADIUS
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel.array import listed, zeros

_inclination = within(
    "orbit: inclination", "0 to pi rad", lambda value: (value >= 0.0) & (value <= np.pi), "rad"
)


class CircularOrbit(Checked):
    """Circular orbit without perturbations, for the environment torques.

    Attributes:
        rate: Mean motion n, rad/s.
        inclination: Inclination of the orbital plane to the inertial x-y plane, rad.
        ascending_node: Angle of the ascending node, from inertial x towards y, rad.
        latitude: Argument of latitude at time 0, from the ascending node, rad.
    """

    rate: Annotated[Scalar, positive("orbital rate", "rad/s")]
    inclination: Annotated[Scalar, _inclination] = 0.0
    ascending_node: Annotated[Scalar, signed("size of the orbit's ascending_node", "rad")] = 0.0
    latitude: Annotated[Scalar, signed("size of the orbit's latitude", "rad")] = 0.0

    @classmethod
    def at_altitude(cls, altitude: float, **elements: Scalar) -> "CircularOrbit":
        """Create an Earth orbit from its altitude.

        Args:
            altitude: Altitude above the equatorial radius, m.
            elements: Other attributes.

        Raises:
            InputError: The altitude is not above 0.
        """
        require("altitude", altitude, "m", positive=True)
        return cls(float(np.sqrt(EARTH / (EARTH_RADIUS + altitude) ** 3)), **elements)

    def zenith(self, time: Scalar) -> Vector3:
        """Unit vector from the centre of the Earth to the spacecraft, inertial axes.

        Args:
            time: Time, s.
        """
        angle = self.latitude + self.rate * time
        along, across = jnp.cos(angle), jnp.sin(angle)
        node, tilt = jnp.asarray(self.ascending_node), jnp.asarray(self.inclination)
        level = across * jnp.cos(tilt)
        return jnp.stack(
            [
                along * jnp.cos(node) - level * jnp.sin(node),
                along * jnp.sin(node) + level * jnp.cos(node),
                across * jnp.sin(tilt),
            ]
        )

    def gradient(self, time: Scalar) -> Scalar:
        """Gravitational parameter over the cubed distance, 1/s²: the squared mean motion."""
        del time
        return jnp.asarray(self.rate) ** 2


class GravityGradient(Checked):
    """Gravity gradient torque T = 3 n² r x J r, n² = mu / R³.

    r is the zenith in body axes, J the inertia with the wheels locked, mu the gravitational
    parameter of the Earth and R the distance from its centre. The Earth is a point mass. P. C.
    Hughes, "Spacecraft Attitude Dynamics", section 8.1.

    Attributes:
        orbit: Orbit of the spacecraft.
        scale: Factor on the torque.
    """

    orbit: CircularOrbit | OrbitEnvironment
    scale: Annotated[Scalar, size("scale of the gravity gradient", "1")] = 1.0

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m; see the module."""
        zenith = to_body(attitude, self.orbit.zenith(time))
        pull = jnp.cross(zenith, spacecraft.inertia_locked() @ zenith)
        return 3.0 * self.scale * self.orbit.gradient(time) * pull


class HarmonicTorque(Checked):
    """Periodic torque T = constant + sum over k of cosine_k cos(k n t) + sine_k sin(k n t).

    A Fourier series over the orbit, in body axes. It represents aerodynamic, solar and residual
    magnetic torques on a spacecraft with constant attitude.

    Attributes:
        rate: Angular frequency n of the first harmonic, rad/s; usually the orbital rate.
        constant: Constant torque, (3,), N·m.
        cosine: Cosine amplitudes, (harmonics, 3), N·m.
        sine: Sine amplitudes, (harmonics, 3), N·m; as many as cosine amplitudes.
    """

    rate: Annotated[Scalar, size("rate of the disturbance", "rad/s")]
    constant: Annotated[Vector3, signed("size of the constant disturbance", "N·m")] = zeros()
    cosine: Annotated[
        Float[Array, "harmonics 3"], signed("size of a disturbance's cosine", "N·m")
    ] = eqx.field(converter=listed, default_factory=lambda: np.zeros((1, 3)))
    sine: Annotated[Float[Array, "harmonics 3"], signed("size of a disturbance's sine", "N·m")] = (
        eqx.field(converter=listed, default_factory=lambda: np.zeros((1, 3)))
    )

    def check_own(self) -> None:
        """Validate shapes.

        Raises:
            InputError: A shape differs from those of the attributes.
        """
        constant, cosine, sine = map(np.shape, (self.constant, self.cosine, self.sine))
        if constant[-1:] != (3,) or cosine[-1:] != (3,) or sine != cosine or len(sine) < 2:
            raise InputError(
                f"disturbance torque: found shapes {constant}, {cosine}, {sine}, expected (3,) and "
                "twice (harmonics, 3)"
            )

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """Torque in body axes, (3,), N·m; see the module."""
        del spacecraft, attitude
        angle = self.rate * time * (1.0 + jnp.arange(len(self.cosine)))
        return self.constant + jnp.cos(angle) @ self.cosine + jnp.sin(angle) @ self.sine
