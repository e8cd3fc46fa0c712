"""Uncertainty of a wheel after a further record, from the exact sensitivities of its speed.

The information of a record of speeds with white noise adds to that of the earlier estimates;
effects outside the model are further unknowns. Many
wheels and currents are evaluated by one compiled program, in which the currents are data.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.experiment.record_effects import (
    RecordEffects,
    drift_shapes,
    drifting_torques,
    level_shapes,
)
from gyrostat.identification.fit.prediction import compiled_response, wheel_dimensions
from gyrostat.identification.uncertainty.torque_noise import RETURN
from gyrostat.wheel.friction import Friction

CHECKPOINTS = 30
"""Number of times in a record at which the uncertainty is evaluated."""
LANES = 64
"""Number of records in one call of the compiled program."""
UNKNOWN_START = 10.0
"""A-priori sigma of the initial speed, in standard deviations of the measured speed."""


NO_EFFECTS = RecordEffects()


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
    names = (*wheel_dimensions(model), "current_bias")
    bias = names.index("current_bias")
    drifting = jnp.asarray(drifting_torques(model, names))
    at_rest = jnp.array([names.index(n) for n in model.vanishing_at], dtype=int)

    def effect_columns(theta, slopes, jacobian, shapes, levels):
        """Derivatives of the speed by drifts, errors of the current and ripple, (N, c)."""
        local = slopes[:, 1:]
        torques = local @ (drifting * theta[:-1]).T
        drifts = (torques[:, :, None] * shapes[:, None, :]).reshape(len(shapes), -1)
        inputs = jnp.column_stack([drifts, levels * local[:, bias, None]])

        def interval(state, sample):
            state = sample[0] * state + sample[1]
            return state, state

        start = jnp.zeros(inputs.shape[1])
        rows = jax.lax.scan(interval, start, (slopes[:, 0], inputs))[1]
        rows = jnp.concatenate([start[None], rows])
        return jnp.column_stack([rows, jacobian[:, at_rest].sum(axis=1)])

    def lane(theta, current, levels, time, noise, parts, root, shapes, sigmas):
        index, inside = parts
        still = jnp.zeros_like(time)
        speed, jacobian, slopes, resolved = respond(
            theta, time, current, still > 0.0, still, len(time)
        )
        starts = (speed[:-1] == 0.0) & (speed[1:] != 0.0)
        # information of the mean of a torque with the correlation exp(-angle / RETURN)
        angle = jnp.cumsum(0.5 * jnp.abs(speed[1:] + speed[:-1]) * jnp.diff(time))
        last = jax.lax.cummax(jnp.where(starts, angle, -jnp.inf))
        apart = angle - jnp.append(-jnp.inf, last[:-1])
        alone = jnp.where(starts, jnp.tanh(0.5 * apart / RETURN), 0.0)
        counts = jnp.concatenate([jnp.zeros((1, 2)), jnp.column_stack([starts, alone])])
        events, angles = jnp.cumsum((counts[index] * inside[..., None]).sum(axis=1), axis=0).T
        # in units of the earlier uncertainty, so that the matrix is well conditioned
        known = jnp.column_stack([jacobian[:, jnp.array(places)], jacobian[:, -1]]) @ root
        effects = effect_columns(theta, slopes, jacobian, shapes, levels) * sigmas
        rows = jnp.column_stack([known, effects])[index] * inside[..., None] / noise
        increments = jnp.einsum("kli,klj->kij", rows, rows)
        information = jnp.eye(rows.shape[-1]) + jnp.cumsum(increments, axis=0)
        # the ripple that a record shows is its mean over independent angles
        information = information.at[:, -1, -1].add(jnp.maximum(angles, 1.0) - 1.0)
        size = len(root)
        inverse = jnp.linalg.inv(information)[:, :size, :size]
        covariance = (root @ inverse @ root.T)[:, :-1, :-1]
        sound = resolved & jnp.all(jnp.isfinite(covariance))
        return covariance, events, angles, speed, sound

    return jax.jit(jax.vmap(lane, (0, 0, 0, *(None,) * 6)))


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
    effects: RecordEffects = NO_EFFECTS,
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
        effects: Effects outside the model, unknown in the record.
    """
    count = len(places)
    full = np.zeros((count + 1, count + 1))
    full[:count, :count] = root
    full[-1, -1] = UNKNOWN_START * speed_sigma
    parts = _parts(np.searchsorted(checkpoints(time), time * (1.0 - 1e-12)))
    shapes, levels = drift_shapes(time), level_shapes(currents, effects.current_error)
    program = _program(model, tuple(places))
    noise = np.float64(speed_sigma)  # a number of Python would compile the program again
    lanes = [(b, d) for b in range(len(currents)) for d in range(len(wheels))]
    theta = np.column_stack([wheels, np.full(len(wheels), initial_speed)])
    results = []
    for first in range(0, len(lanes), LANES):
        group = [lanes[k % len(lanes)] for k in range(first, first + LANES)]
        b, d = (np.array(index) for index in zip(*group, strict=True))
        result = program(
            theta[d], currents[b], levels[b], time, noise, parts, full, shapes, effects.sigmas()
        )
        results.append([np.asarray(column) for column in result])
    fields = [np.concatenate(column)[: len(lanes)] for column in zip(*results, strict=True)]
    shape = (len(currents), len(wheels))
    return Gained(*(column.reshape(*shape, *column.shape[1:]) for column in fields))


def _parts(part: NDArray[np.intp]) -> tuple[NDArray[np.intp], Matrix]:
    """Samples up to each checkpoint after the one before, (k, l), and whether there is one, (k, l).

    Args:
        part: Checkpoint of each sample, (N,), not decreasing.
    """
    counts = np.bincount(part, minlength=CHECKPOINTS)
    place = np.arange(counts.max())
    starts = np.cumsum(counts) - counts
    index = np.minimum(starts[:, None] + place, len(part) - 1)
    return index, (place < counts[:, None]).astype(float)
