"""Steady response of a spacecraft to the disturbances of its wheels, as rotating vectors."""

from typing import Any, NamedTuple

from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft.flexible.modes import FlexibleModes
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.wheel_harmonics import Gain

Rotating = Float[Array, "harmonics 3 wheels"]
"""A vector for each harmonic and wheel, body axes."""


class Phasor(NamedTuple):
    """Complex amplitude of a vector that rotates or swings: Re(amplitude e^{i phase})."""

    real: Rotating
    imaginary: Rotating

    def times(self, gain: Gain) -> "Phasor":
        """Product with a complex factor for each harmonic and wheel."""
        real, imaginary = (jnp.asarray(part)[..., None, :] for part in gain)
        return Phasor(
            real * self.real - imaginary * self.imaginary,
            real * self.imaginary + imaginary * self.real,
        )

    def at(self, phase: Float[Array, "harmonics wheels"]) -> Rotating:
        """The vectors at their phases, (harmonics, wheels), rad."""
        cosine, sine = (part[:, None, :] for part in (jnp.cos(phase), jnp.sin(phase)))
        return self.real * cosine - self.imaginary * sine


def rotation_of_body(
    spacecraft: Spacecraft,
    modes: FlexibleModes | None,
    number: Float[Array, " harmonics"],
    speed: PerWheel,
    force: Phasor,
    torque: Phasor,
) -> Phasor:
    """Rotation vectors of the body under rotating loads, rad.

    The response is that of constant wheel speed. With J the inertia of the spacecraft, and modes
    with the participations D and S, modal mass M and frequencies W (`FlexibleModes`), the loads
    f W_s², t W_s² at the frequency w = h W_s give

        (W² - w² (M - D J^-1 D^T) + 2i w Z W) q = -(D J^-1 t + S f / sqrt(m)),
        rotation = -J^-1 (t / h² + W_s² D^T q).

    Args:
        spacecraft: Spacecraft, undeformed.
        modes: Its modes; None for a rigid body.
        number: Multiples h of the wheel speed.
        speed: Wheel speeds W_s, (wheels,), rad/s.
        force: Forces over the squared wheel speed, kg·m.
        torque: Torques about the centre of mass over the squared wheel speed, kg·m².
    """
    inverse = inverse_definite(jnp.asarray(spacecraft.inertia))
    scale = number[:, None, None] ** -2
    moment = [scale * part for part in torque]
    if modes is not None:
        rotational, translational = jnp.asarray(modes.participation), modes.translation
        mass = jnp.eye(modes.count) - rotational @ inverse @ rotational.T
        forcing = [(rotational @ inverse) @ part for part in torque]
        if translational is not None:
            mass = mass - jnp.asarray(translational) @ jnp.asarray(translational).T
            share = jnp.asarray(translational) / jnp.sqrt(jnp.asarray(spacecraft.mass))
            forcing = [a + share @ part for a, part in zip(forcing, force, strict=True)]
        frequency = number[:, None] * speed
        modal = _deflection(modes, mass, frequency, *forcing)
        moment = [a - speed**2 * (rotational.T @ q) for a, q in zip(moment, modal, strict=True)]
    real, imaginary = (-inverse @ part for part in moment)
    return Phasor(real, imaginary)


def _deflection(modes: FlexibleModes, mass: Any, frequency: Any, real: Any, imaginary: Any) -> Any:
    """Modal coordinates under forces, as two parts: (harmonics, modes, wheels) each.

    Elimination without pivoting: the damping keeps every pivot away from zero.
    """
    mode = jnp.asarray(modes.frequency)
    w, eye = frequency[..., None, None], jnp.eye(modes.count)
    rows = (
        jnp.concatenate([mode**2 * eye - w**2 * mass, jnp.swapaxes(real, 1, 2)[..., None]], -1),
        jnp.concatenate(
            [
                2.0 * w * jnp.asarray(modes.damping) * mode * eye,
                jnp.swapaxes(imaginary, 1, 2)[..., None],
            ],
            -1,
        ),
    )
    for k in range(modes.count):
        a, b = (part[..., k, k][..., None] for part in rows)
        size = a**2 + b**2
        row = [part[..., k, :] for part in rows]
        pivot = ((row[0] * a + row[1] * b) / size, (row[1] * a - row[0] * b) / size)
        below = [part[..., :, k, None] for part in rows]
        p, q = (part[..., None, :] for part in pivot)
        product = (below[0] * p - below[1] * q, below[0] * q + below[1] * p)
        at = eye[:, k, None] == 1.0
        rows = (jnp.where(at, p, rows[0] - product[0]), jnp.where(at, q, rows[1] - product[1]))
    return tuple(jnp.swapaxes(part[..., -1], 1, 2) for part in rows)
