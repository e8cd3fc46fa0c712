"""External torques on a spacecraft in a circular orbit, for `Gyrostat.environment`.

Each is called with the spacecraft, its attitude and the time, s, for a torque (3,) in body axes,
N·m. The total momentum of a gyrostat is the integral of their sum, whatever the wheels do.
"""

from typing import Annotated

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.core.validation import require
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel.array import listed, zeros

EARTH = 3.986004418e14
"""m³/s²: gravitational parameter of the Earth (IERS Conventions, 2010)."""
EARTH_RADIUS = 6378137.0
"""m: equatorial (WGS 84)."""


class CircularOrbit(Checked):
    """A circular orbit without perturbations: what torques along it need, no more.

    Attributes:
        rate: mean motion n, rad/s.
        inclination: of the orbit's plane to the inertial x-y plane, rad.
        ascending_node: from x towards y, rad.
        latitude: argument of latitude at time 0, from the ascending node, rad.
    """

    rate: Annotated[Scalar, positive("orbital rate", "rad/s")]
    inclination: Annotated[Scalar, signed("size of the orbit's inclination", "rad")] = 0.0
    ascending_node: Annotated[Scalar, signed("size of the orbit's ascending_node", "rad")] = 0.0
    latitude: Annotated[Scalar, signed("size of the orbit's latitude", "rad")] = 0.0

    @classmethod
    def at_altitude(cls, altitude: float, **elements: Scalar) -> "CircularOrbit":
        """An orbit of the Earth.

        Args:
            altitude: above the equator's radius, m.
            elements: other attributes.

        Raises:
            InputError: the altitude is not above 0.
        """
        require("altitude", altitude, "m", positive=True)
        return cls(float(np.sqrt(EARTH / (EARTH_RADIUS + altitude) ** 3)), **elements)

    def zenith(self, time: Scalar) -> Vector3:
        """Unit vector from the centre of the Earth to the spacecraft, inertial axes.

        Args:
            time: s.
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


class GravityGradient(Checked):
    """T = 3 n² r x J r, r the zenith in body axes and J the inertia with its wheels.

    P. C. Hughes, "Spacecraft Attitude Dynamics", section 8.1.

    Attributes:
        orbit: of the spacecraft.
    """

    orbit: CircularOrbit

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """See the module."""
        zenith = to_body(attitude, self.orbit.zenith(time))
        pull = jnp.cross(zenith, spacecraft.inertia_locked() @ zenith)
        return 3.0 * jnp.asarray(self.orbit.rate) ** 2 * pull


class HarmonicTorque(Checked):
    """T = constant + sum over k of cosine_k cos(k n t) + sine_k sin(k n t), in body axes.

    What aerodynamic drag, sunlight and residual dipoles do to a spacecraft that keeps its attitude,
    as Fourier series over the orbit.

    Attributes:
        rate: of the first harmonic n, rad/s; an orbit's, as a rule.
        constant: (3,) N·m.
        cosine: (harmonics, 3) N·m.
        sine: (harmonics, 3) N·m, as many.
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
            InputError: Other shapes than those of the attributes.
        """
        constant, cosine, sine = map(np.shape, (self.constant, self.cosine, self.sine))
        if constant[-1:] != (3,) or cosine[-1:] != (3,) or sine != cosine or len(sine) < 2:
            raise InputError(
                f"disturbance torque: found shapes {constant}, {cosine}, {sine}, expected (3,) and "
                "twice (harmonics, 3)"
            )

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """See the module."""
        del spacecraft, attitude
        angle = self.rate * time * (1.0 + jnp.arange(len(self.cosine)))
        return self.constant + jnp.cos(angle) @ self.cosine + jnp.sin(angle) @ self.sine
