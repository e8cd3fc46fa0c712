"""Uncertainty of a wheel after a further record, from the exact sensitivities of its speed.

The information of a record of speeds with white noise adds to that of the earlier estimates. Many
wheels and currents are evaluated by one compiled program, in which the currents are data.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import compiled_response
from gyrostat.identification.uncertainty.torque_noise import RETURN
from gyrostat.wheel.friction import Friction

CHECKPOINTS = 30
"""Number of times in a record at which the uncertainty is evaluated."""
LANES = 64
"""Number of records in one call of the compiled program."""
UNKNOWN_START = 10.0
"""A-priori sigma of the initial speed, in standard deviations of the measured speed."""


class Gained(NamedTuple):
    """Uncertainty after b currents on d wheels, at k times.

    Attributes:
        covariance: Covariance of the n uncertain parameters, (b, d, k, n, n), SI.
        events: Number of breakaways from rest so far, (b, d, k).
        angles: Number of breakaways at independent angles that determine the mean of the torque
            ripple as well as these do, (b, d, k).
        speed: Speed at the samples, (b, d, N), rad/s.
        resolved: Whether the motion was resolved and all numbers are finite, (b, d).
    """

    covariance: Vector
    events: Vector
    angles: Vector
    speed: Vector
    resolved: Vector


@lru_cache
def _program(model: type[Friction], places: tuple[int, ...]):
    """Compile the information of LANES records, each with its own wheel and current."""
    respond = compiled_response(model, "zero-order")

    def lane(theta, current, time, noise, part, root):
        still = jnp.zeros_like(time)
        speed, jacobian, _, resolved = respond(theta, time, current, still > 0.0, still, len(time))
        # in units of the earlier uncertainty, so that the matrix is well conditioned
        columns = jnp.column_stack([jacobian[:, jnp.array(places)], jacobian[:, -1]])
        rows = columns @ root / noise
        increments = jax.ops.segment_sum(rows[:, :, None] * rows[:, None, :], part, CHECKPOINTS)
        information = jnp.eye(len(root)) + jnp.cumsum(increments, axis=0)
        covariance = (root @ jnp.linalg.inv(information) @ root.T)[:, :-1, :-1]
        starts = (speed[:-1] == 0.0) & (speed[1:] != 0.0)
        # information of the mean of a torque with the correlation exp(-angle / RETURN)
        angle = jnp.cumsum(0.5 * jnp.abs(speed[1:] + speed[:-1]) * jnp.diff(time))
        last = jax.lax.cummax(jnp.where(starts, angle, -jnp.inf))
        apart = angle - jnp.append(-jnp.inf, last[:-1])
        alone = jnp.where(starts, jnp.tanh(0.5 * apart / RETURN), 0.0)
        counts = jnp.column_stack([starts, alone])
        events, angles = jax.ops.segment_sum(counts, part[1:], CHECKPOINTS).T
        sound = resolved & jnp.all(jnp.isfinite(covariance))
        return covariance, jnp.cumsum(events), jnp.cumsum(angles), speed, sound

    return jax.jit(jax.vmap(lane, (0, 0, None, None, None, None)))


def checkpoints(time: Vector) -> Vector:
    """Times at which the uncertainty is evaluated, (k,), s; the last one is the end.

    Args:
        time: Sample times, (N,), s, from zero.
    """
    return time[-1] * np.arange(1, CHECKPOINTS + 1) / CHECKPOINTS


def information_gained(
    model: type[Friction],
    wheels: Matrix,
    currents: Matrix,
    time: Vector,
    *,
    places: Sequence[int],
    root: Matrix,
    speed_sigma: float,
    initial_speed: float = 0.0,
) -> Gained:
    """Uncertainty of the parameters after a record of each current.

    The initial speed is estimated with the parameters, as `identify` does. A wheel that starts
    exactly at rest keeps the error of that estimate until it breaks away, which is conservative.

    Args:
        model: Friction model.
        wheels: Parameters of d wheels: motor constant, inertia, friction, current bias, (d, m), SI.
        currents: Currents, held from sample to sample, (b, N), A.
        time: Sample times, (N,), s, from zero.
        places: Indices of the n uncertain parameters among the m.
        root: Square root of their covariance before the record, (n, n), SI.
        speed_sigma: Standard deviation of the measured speed at each sample, rad/s.
        initial_speed: Speed at the first sample, rad/s.
    """
    count = len(places)
    full = np.zeros((count + 1, count + 1))
    full[:count, :count] = root
    full[-1, -1] = UNKNOWN_START * speed_sigma
    part = np.searchsorted(checkpoints(time), time * (1.0 - 1e-12))
    program = _program(model, tuple(places))
    noise = np.float64(speed_sigma)  # a number of Python would compile the program again
    lanes = [(b, d) for b in range(len(currents)) for d in range(len(wheels))]
    theta = np.column_stack([wheels, np.full(len(wheels), initial_speed)])
    parts = []
    for first in range(0, len(lanes), LANES):
        group = [lanes[k % len(lanes)] for k in range(first, first + LANES)]
        b, d = (np.array(index) for index in zip(*group, strict=True))
        result = program(theta[d], currents[b], time, noise, jnp.asarray(part), full)
        parts.append([np.asarray(column) for column in result])
    fields = [np.concatenate(column)[: len(lanes)] for column in zip(*parts, strict=True)]
    shape = (len(currents), len(wheels))
    return Gained(*(column.reshape(*shape, *column.shape[1:]) for column in fields))
