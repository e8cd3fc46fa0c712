"""Prediction errors of a linearised record under random torques: a Kalman filter in O(N).

The residual is r = S theta + x + e with the speed error x of
`gyrostat.identification.uncertainty.speed_error`. One filter serves all columns of [r, S], because
its gains do not depend on the data, and many noise levels at once. The sums of squares and products
of the whitened columns are sufficient for a linear regression: they give the likelihood of every
hypothesis in closed form (Harvey 1989, "Forecasting, structural time series models and the Kalman
filter", sections 3.4 and 3.7).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import padded
from gyrostat.identification.uncertainty.effects import LONGEST, spare
from gyrostat.identification.uncertainty.speed_error import corrected, first_covariance, predicted
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise

BLOCK = 64
"""Samples over which products of whitened columns are summed at once."""


class Innovations(NamedTuple):
    """Whitened columns of one record for each of g noise levels.

    Attributes:
        products: Sums of products of the whitened columns, (g, c, c).
        log_variance: Sum of the logarithms of the variances of the prediction errors, (g,).
        samples: Number of samples used, each with an error of its own.
        least: Smallest variance of the measured speed over the assumed one.
    """

    products: Vector
    log_variance: Vector
    samples: float
    least: float = 0.0

    def leading(self, count: int) -> "Innovations":
        """Innovations of the first columns only."""
        return self._replace(products=self.products[:, :count, :count])

    def with_levels(self, other: "Innovations") -> "Innovations":
        """Innovations for the levels of both, of the same columns."""
        return self._replace(
            products=np.concatenate([self.products, other.products]),
            log_variance=np.concatenate([self.log_variance, other.log_variance]),
        )


@stored_function
def _filter(columns, variance, intervals, squared, state, covariance, products, logs):
    """Whiten columns (N, c) for g noise levels, from the results for earlier samples."""

    def sample(carry, entry):
        state, covariance, logs = carry
        row, noise, interval = entry
        error = row - state[0]
        total = covariance[0] + noise
        valid = jnp.isfinite(noise)
        weight = jnp.where(valid, 1.0 / total, 0.0)
        logs = logs + jnp.where(valid, jnp.log(total), 0.0)
        gains, covariance = corrected(covariance, weight)
        state = [each + k[:, None] * error for each, k in zip(state, gains, strict=True)]
        ahead = predicted(tuple(state), covariance, interval, squared.T)
        return (*ahead, logs), error * jnp.sqrt(weight)[:, None]

    def block(carry, entries):
        state, covariance, products, logs = carry
        (state, covariance, logs), white = jax.lax.scan(sample, (state, covariance, logs), entries)
        # a sum over a block costs far less memory traffic than one over each sample
        products = products + jnp.einsum("tgi,tgj->gij", white, white)
        return (state, covariance, products, logs), None

    start = (tuple(state), tuple(covariance), products, logs)
    entries = [each.reshape(-1, BLOCK, *each.shape[1:]) for each in (columns, variance, intervals)]
    last, _ = jax.lax.scan(block, start, tuple(entries))
    return jnp.stack(last[0]), jnp.stack(last[1]), last[2], last[3]


def innovations(
    columns: Sequence[Matrix],
    variance: Vector,
    transition: Vector,
    noise: TorqueNoise,
    levels: Matrix,
) -> Innovations:
    """Whiten the columns of a record under random torques of several levels.

    Args:
        columns: Residuals and derivatives of the speed, parts of (N, k) with c columns together;
            any finite value where a sample is missing.
        variance: Variance of the measured speed, (N,), in the squared unit of the columns;
            infinite where a sample is missing.
        transition: Derivative of the speed at the end of each interval by that at its start,
            (N - 1,).
        noise: Random torque at level one, SI.
        levels: Levels of the ripple at crossings and of the random-walk torque, (g, 2).
    """
    count, width = len(variance), sum(part.shape[1] for part in columns)
    size = min(len(padded(variance)), LONGEST)
    size += -size % BLOCK
    intervals = np.pad(noise.intervals(transition), ((0, 1), (0, 0)))
    squared, full = levels**2, width + spare(width)
    first = first_covariance(np.array([noise.first, noise.ripple]), squared.T)
    carry = (
        np.zeros((3, len(levels), full)),
        np.stack(first),
        np.zeros((len(levels), full, full)),
        np.zeros(len(levels)),
    )
    for start in range(0, count, size):
        block = slice(start, start + size)
        fill = max(0, start + size - count)
        carry = _filter(
            np.pad(np.hstack([part[block] for part in columns]), ((0, fill), (0, full - width))),
            np.pad(variance[block], (0, fill), constant_values=np.inf),
            np.pad(intervals[block], ((0, fill), (0, 0))),
            squared,
            *carry,
        )
    products = np.asarray(carry[2])[:, :width, :width]
    return Innovations(products, np.asarray(carry[3]), int(np.isfinite(variance).sum()))
