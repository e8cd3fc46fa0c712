"""Sun sensors: coarse cells, and a measured direction of the Sun."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float, PRNGKeyArray

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, direction, positive, signed, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import angle_between, from_rotation_vector, to_body, to_inertial
from gyrostat.spacecraft.orbit.orbit_environment import OrbitEnvironment
from gyrostat.spacecraft.torques.eclipse import sunlight
from gyrostat.wheel.array import UNIT_TOLERANCE, listed, zeros

FACES = np.kron(np.eye(3), np.array([[1.0], [-1.0]]))
"""Normals of the faces of a cube: +x, -x, +y, -y, +z, -z, (6, 3)."""
LEAST_LIGHT = 0.5
"""Visible share of the Sun's disc below which a direction is not measured."""


def sun_in_body(orbit: OrbitEnvironment, attitude: Quaternion, time: Scalar) -> Vector3:
    """Unit vector from the spacecraft to the Sun in body axes, (3,), at a time, s."""
    along = orbit.sun(time) - orbit.position(time)
    return to_body(attitude, along / jnp.sqrt(along @ along))


class CoarseSunSensors(Checked):
    """Currents of sun cells, (cells,), 1 at normal incidence; for `Sampled`.

    The current is (1 + k) max(0, n.s) v + noise, with the normal n of the cell, the direction s of
    the Sun and the visible share v of its disc. Sunlight that the Earth reflects (albedo) is not
    modelled; it causes errors of 10 degrees and more in low orbits. F. L. Markley, J. L. Crassidis,
    "Fundamentals of Spacecraft Attitude Determination and Control", section 4.3.

    Attributes:
        orbit: Orbit with the Sun.
        normals: Normals of the cells in body axes, unit length, (cells, 3); the faces of a cube by
            default.
        sigma: Standard deviation of the white noise of each cell.
        scale_factor: Error k of each cell, (cells,), or one value for all.
    """

    orbit: OrbitEnvironment
    normals: Float[Array, "cells 3"] = eqx.field(converter=listed, default_factory=FACES.copy)
    sigma: Annotated[Scalar, size("sun cell sigma")] = 0.0
    scale_factor: Annotated[Float[Array, " cells"] | float, signed("size of the cell error")] = (
        eqx.field(converter=listed, default=0.0)
    )
    unit = "1"

    def check_own(self) -> None:
        """Validate the normals.

        Raises:
            InputError: They are not (cells, 3) or not of unit length.
        """
        normals = np.asarray(self.normals, dtype=float)
        if normals.ndim < 2 or normals.shape[-1] != 3:
            raise InputError(
                f"normals of the sun cells: found shape {normals.shape}, expected n, 3"
            )
        if not np.all(np.abs(np.linalg.norm(normals, axis=-1) - 1.0) < UNIT_TOLERANCE):
            raise InputError(
                "normals of the sun cells: found another length, expected unit vectors"
            )

    def __call__(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Float[Array, " cells"]:
        """Measured currents, (cells,); see `InstantSensor`."""
        light = sunlight(self.orbit.position(time), self.orbit.sun(time))
        normals = jnp.asarray(self.normals)
        cosine = normals @ sun_in_body(self.orbit, state.attitude, time)
        current = (1.0 + jnp.asarray(self.scale_factor)) * jnp.maximum(cosine, 0.0) * light
        return current + self.sigma * jax.random.normal(key, (len(normals),))


class SunSensor(Checked):
    """Measured direction of the Sun in body axes, a unit vector, (3,); for `Sampled`.

    The vector is zero if the Sun is not seen: if it is outside the field of view, or if less than
    half of its disc is visible. Zero instead of NaN keeps commands finite.

    Attributes:
        orbit: Orbit with the Sun.
        sigma: Standard deviation of the error about each axis across the Sun, rad.
        misalignment: Rotation vector from body axes to sensor axes, (3,), rad.
        boresight: Centre of the field of view in body axes, (3,), of any length.
        field_of_view: Largest angle between boresight and Sun, rad; pi: all directions.
    """

    orbit: OrbitEnvironment
    sigma: Annotated[Scalar, size("sun sensor sigma", "rad")] = 0.0
    misalignment: Annotated[Vector3, signed("size of the sun sensor misalignment", "rad")] = zeros()
    boresight: Annotated[Vector3, direction("boresight of the sun sensor")] = eqx.field(
        converter=listed, default_factory=lambda: np.array([0.0, 0.0, 1.0])
    )
    field_of_view: Annotated[Scalar, positive("field of view", "rad")] = np.pi
    unit = "1"

    def __call__(self, state: Any, time: Scalar, key: PRNGKeyArray) -> Vector3:
        """Measured direction, (3,), or zero; see `InstantSensor`."""
        sun = sun_in_body(self.orbit, state.attitude, time)
        light = sunlight(self.orbit.position(time), self.orbit.sun(time))
        inside = angle_between(jnp.asarray(self.boresight), sun) <= self.field_of_view
        mounted = to_body(from_rotation_vector(jnp.asarray(self.misalignment)), sun)
        turn = self.sigma * jax.random.normal(key, (3,))
        measured = to_inertial(from_rotation_vector(turn), mounted)
        return jnp.where(inside & (light >= LEAST_LIGHT), measured, 0.0)
