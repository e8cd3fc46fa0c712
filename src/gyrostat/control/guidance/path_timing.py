"""Fastest progress along a path within the torque and momentum of the working wheels."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Array, Bool

from gyrostat.control.guidance.bowed_path import BowedPath, PathSamples
from gyrostat.control.guidance.slew import SlewLimits
from gyrostat.control.guidance.slew_profile import NO_LIMIT, SlewProfile
from gyrostat.control.guidance.wheel_envelope import SLOWEST, SMALL, WheelRoom
from gyrostat.core import rotations
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp

SHARES = np.geomspace(0.5, 0.01, 7), np.geomspace(0.5, 0.001, 120)
"""Shares of the path in which the progress gathers speed, in a coarse and in the final search."""


class PathTiming(NamedTuple):
    """Progress from 0 to 1 with constant acceleration, constant rate and constant deceleration.

    Attributes:
        rate: Largest rate of the progress, 1/s.
        acceleration: Its acceleration, 1/s².
        crossings: Number of wheels that pass through zero speed; a wheel that starts at zero does
            not count.
        has_room: Whether the wheels can hold the momentum of a body at rest in each attitude of the
            path, and turn it at `SLOWEST`; if not, their momentum does not limit the rate further.
    """

    rate: Scalar
    acceleration: Scalar
    crossings: Scalar
    has_room: Bool[Array, ""]

    @property
    def duration(self) -> Scalar:
        """Duration without jerk limit, s."""
        return 1.0 / self.rate + self.rate / self.acceleration

    def profile(self, samples: PathSamples, jerk: Scalar) -> SlewProfile:
        """Profile of the progress with a jerk limit.

        Args:
            samples: The path sampled.
            jerk: Jerk limit of the largest rotation that a progress causes, rad/s³.
        """
        turned = jnp.max(jnp.sqrt(jnp.sum(samples.rate**2, axis=-1)))
        jerk = jnp.minimum(jerk, NO_LIMIT) / jnp.maximum(turned, SMALL)
        return SlewProfile.fastest(jnp.ones(()), self.rate, self.acceleration, jerk)


def fastest(
    path: BowedPath,
    samples: PathSamples,
    limits: SlewLimits,
    room: WheelRoom | None,
    crossing_time: Scalar | None = None,
    ramps: np.ndarray = SHARES[0],
) -> PathTiming:
    """Fastest timing within the limits at all samples.

    While the progress gathers speed over a share r of the path, its rate is at most V sqrt(s / r)
    and its acceleration V² / (2 r). Torque and momentum of a wheel are at most the sums of the
    sizes of their terms, so that the largest V of each r has a closed form. With
    `crossing_time`, a second V of each r keeps the signs of the wheel speeds.

    Args:
        path: Path.
        samples: The path sampled.
        limits: Limits of the slew.
        room: Wheels that the slew may use; None: they are not considered.
        crossing_time: Time that may be lost to avoid a zero crossing of a wheel, s; None: the
            fastest timing.
        ramps: Shares of the path in which the progress gathers speed, (shares,); at most 0.5.
    """
    s = np.linspace(0.0, 1.0, len(samples.rate))
    nearest = np.minimum(s, 1.0 - s) + s[1]  # of both neighbours, the speed between the samples
    speed = np.sqrt(np.minimum(nearest / ramps[:, None], 1.0))
    size, bend = (jnp.sqrt(jnp.sum(each**2, axis=-1)) for each in (samples.rate, samples.slope))
    largest = jnp.minimum(limits.acceleration, NO_LIMIT), jnp.minimum(limits.rate, NO_LIMIT)
    by_square = (0.5 / ramps)[:, None] * size + bend * speed**2  # (shares, samples)
    rates = jnp.sqrt(largest[0] / (jnp.max(by_square, axis=-1) + SMALL))
    rates = jnp.minimum(rates, largest[1] / (jnp.max(size * speed, axis=-1) + SMALL))
    held, spun = jnp.zeros((1, 1, len(s))), jnp.zeros((1, len(ramps), len(s)))
    has_room = jnp.array(True)
    if room is not None:
        torque_rates, held, spun = _wheel_terms(path, samples, room, speed, ramps)
        rates = jnp.minimum(rates, torque_rates)
        free = room.momentum[:, None, None] + jnp.sign(spun) * held
        momentum_rates = _least_quotient(jnp.maximum(free, 0.0), spun)
        least = SLOWEST / jnp.maximum(jnp.max(size), SMALL)
        has_room = jnp.all(jnp.abs(held[:, 0]) <= room.momentum[:, None])
        has_room &= jnp.max(momentum_rates) >= least
        rates = jnp.minimum(rates, jnp.maximum(momentum_rates, least))
    start, shares = jnp.sign(held[:, 0, :1]), jnp.asarray(ramps)
    lost: Scalar = 0.0
    if crossing_time is not None:
        # slower, no wheel that does not already rest leaves its sign
        toward = jnp.where(start[:, None] * spun > 0.0, spun, 0.0)
        same_sign = _least_quotient(jnp.maximum(start[:, None] * held, 0.0), toward)
        rates = jnp.concatenate([rates, jnp.minimum(rates, 0.999 * same_sign)])
        shares, spun = jnp.tile(shares, 2), jnp.tile(spun, (1, 2, 1))
        changes = jnp.any((held - spun * rates[:, None]) * start[:, None] < 0.0, axis=2)
        lost = crossing_time * jnp.sum(changes, axis=0)
    best = jnp.argmin((1.0 + 2.0 * shares) / jnp.maximum(rates, SMALL) + lost)
    rate = jnp.maximum(rates[best], SMALL)
    changes = jnp.any((held[:, 0] - spun[:, best] * rate) * start < 0.0, axis=1)
    acceleration = 0.5 * rate**2 / shares[best]
    return PathTiming(rate, acceleration, jnp.sum(changes), has_room)


def _wheel_terms(
    path: BowedPath, samples: PathSamples, room: WheelRoom, speed: np.ndarray, ramps: np.ndarray
) -> tuple[Array, Array, Array]:
    """Largest rates by torque, (shares,), and momentum of the wheels, (wheels, shares, samples).

    The momentum is the second result less the third times the largest rate of the progress.
    """
    momentum = samples.to_body(rotations.to_body(path.middle, room.total))
    inertial = jnp.abs(room.rows @ room.inertia @ samples.rate.T)[:, None]
    bending = jnp.abs(room.rows @ room.inertia @ samples.slope.T)[:, None]
    turning = jnp.abs(room.rows @ jnp.cross(samples.rate, momentum).T)[:, None]
    square = inertial * (0.5 / ramps)[:, None] + bending * speed**2
    linear, torque = turning * speed, room.torque[:, None, None]
    root = jnp.sqrt(linear**2 + 4.0 * square * torque)
    rates = jnp.min(2.0 * torque / (linear + root + SMALL), axis=(0, 2))
    held = (room.null[:, None] + room.rows @ momentum.T)[:, None]
    return rates, held, (room.rows @ room.locked @ samples.rate.T)[:, None] * speed


def _least_quotient(room: Array, need: Array) -> Array:
    """Largest rate of each share for which the need times the rate is within the room."""
    return jnp.min(room / (jnp.abs(need) + SMALL) + NO_LIMIT * (need == 0.0), axis=(0, 2))
