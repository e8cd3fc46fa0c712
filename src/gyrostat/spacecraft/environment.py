"""External torques on a spacecraft in a circular orbit, for `Gyrostat.environment`.

Each is called with the spacecraft, its attitude and the time, s, for a torque (3,) in body axes,
N·m. The total momentum of a gyrostat is the integral of their sum, whatever the wheels do.
"""

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import to_body
from gyrostat.core.validation import check_parts, require
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.wheel.array import listed

EARTH = 3.986004418e14
"""m³/s²: gravitational parameter of the Earth (IERS Conventions, 2010)."""
EARTH_RADIUS = 6378137.0
"""m: equatorial (WGS 84)."""


class CircularOrbit(eqx.Module):
    """A circular orbit without perturbations: what torques along it need, no more.

    Attributes:
        rate: mean motion n, rad/s.
        inclination: of the orbit's plane to the inertial x-y plane, rad.
        ascending_node: from x towards y, rad.
        latitude: argument of latitude at time 0, from the ascending node, rad.
    """

    rate: Scalar
    inclination: Scalar = 0.0
    ascending_node: Scalar = 0.0
    latitude: Scalar = 0.0

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

    def check(self) -> None:
        """Refuse a rate that is not positive and angles that are not finite, by `InputError`."""
        require("orbital rate", self.rate, "rad/s", positive=True)
        for name in ("inclination", "ascending_node", "latitude"):
            require(f"size of the orbit's {name}", np.abs(getattr(self, name)), "rad")

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


class GravityGradient(eqx.Module):
    """T = 3 n² r x J r, r the zenith in body axes and J the inertia with its wheels.

    P. C. Hughes, "Spacecraft Attitude Dynamics", section 8.1.

    Attributes:
        orbit: of the spacecraft.
    """

    orbit: CircularOrbit

    def check(self) -> None:
        """Refuse what the orbit refuses, by `InputError`."""
        check_parts(self.orbit)

    def __call__(self, spacecraft: Spacecraft, attitude: Quaternion, time: Scalar) -> Vector3:
        """See the module."""
        zenith = to_body(attitude, self.orbit.zenith(time))
        pull = jnp.cross(zenith, spacecraft.inertia_locked() @ zenith)
        return 3.0 * jnp.asarray(self.orbit.rate) ** 2 * pull


class HarmonicTorque(eqx.Module):
    """T = constant + sum over k of cosine_k cos(k n t) + sine_k sin(k n t), in body axes.

    What aerodynamic drag, sunlight and residual dipoles do to a spacecraft that keeps its attitude,
    as Fourier series over the orbit.

    Attributes:
        rate: of the first harmonic n, rad/s; an orbit's, as a rule.
        constant: (3,) N·m.
        cosine: (harmonics, 3) N·m.
        sine: (harmonics, 3) N·m, as many.
    """

    rate: Scalar
    constant: Vector3 = eqx.field(converter=listed, default_factory=lambda: np.zeros(3))
    cosine: Float[Array, "harmonics 3"] = eqx.field(
        converter=listed, default_factory=lambda: np.zeros((1, 3))
    )
    sine: Float[Array, "harmonics 3"] = eqx.field(
        converter=listed, default_factory=lambda: np.zeros((1, 3))
    )

    def check(self) -> None:
        """Refuse what is no series.

        Raises:
            InputError: a rate that is negative, values that are not finite, other shapes.
        """
        require("rate of the disturbance", self.rate, "rad/s")
        require("size of the constant disturbance", np.abs(self.constant), "N·m")
        require("size of a disturbance's cosine", np.abs(self.cosine), "N·m")
        require("size of a disturbance's sine", np.abs(self.sine), "N·m")
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
