"""Prediction errors of a linearised record under random torques: a Kalman filter in O(N).

The residual is r = S theta + x + e with the speed error x of `gyrostat.identification.speed_error`.
One filter serves all columns of [r, S] (its gains do not depend on the data), and many noise levels
at once. The sums of squares and products of the whitened columns are sufficient for a linear
regression: they give the likelihood of every hypothesis in closed form (Harvey 1989, "Forecasting,
structural time series models and the Kalman filter", sections 3.4 and 3.7).
"""

from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.effects import TorqueNoise, spare
from gyrostat.identification.prediction import padded
from gyrostat.identification.speed_error import corrected, first_covariance, predicted


class Innovations(NamedTuple):
    """Whitened columns of one record for each of g noise levels.

    Attributes:
        products: Sums of products of the whitened columns, (g, c, c).
        log_variance: Sum of the logarithms of the variances of the prediction errors, (g,).
        samples: Number of samples used.
    """

    products: Vector
    log_variance: Vector
    samples: int

    def leading(self, count: int) -> "Innovations":
        """Innovations of the first columns only."""
        return self._replace(products=self.products[:, :count, :count])


@stored_function
def _filter(columns, variance, intervals, first, squared):
    """Whiten columns (N, c) for g noise levels; `squared` holds the squared levels, (g, 2)."""
    levels, count = squared.shape[0], columns.shape[1]

    def sample(carry, entry):
        state, covariance, products, logs = carry
        row, noise, interval = entry
        error = row - state[0]
        total = covariance[0] + noise
        used = jnp.isfinite(noise)
        weight = jnp.where(used, 1.0 / total, 0.0)
        products = products + error[:, :, None] * (error * weight[:, None])[:, None, :]
        logs = logs + jnp.where(used, jnp.log(total), 0.0)
        gains, covariance = corrected(covariance, weight)
        state = [each + k[:, None] * error for each, k in zip(state, gains, strict=True)]
        ahead = predicted(tuple(state), covariance, interval, squared.T)
        return (*ahead, products, logs), None

    start = (
        (jnp.zeros((levels, count)),) * 3,
        first_covariance(first, squared.T),
        jnp.zeros((levels, count, count)),
        jnp.zeros(levels),
    )
    last, _ = jax.lax.scan(sample, start, (columns, variance, intervals))
    return last[2], last[3]


def innovations(
    columns: Matrix,
    variance: Vector,
    transition: Vector,
    noise: TorqueNoise,
    levels: Matrix,
) -> Innovations:
    """Whiten the columns of a record under random torques of several levels.

    Args:
        columns: Residuals and derivatives of the speed, (N, c); any finite value where a sample is
            missing.
        variance: Variance of the measured speed, (N,), in the squared unit of the columns;
            infinite where a sample is missing.
        transition: Derivative of the speed at the end of each interval by that at its start,
            (N - 1,).
        noise: Random torque at level one, SI.
        levels: Levels of the ripple at crossings and of the random-walk torque, (g, 2).
    """
    fill, width = len(padded(variance)) - len(variance), columns.shape[1]
    products, logs = _filter(
        np.pad(columns, ((0, fill), (0, spare(width)))),
        np.pad(variance, (0, fill), constant_values=np.inf),
        np.pad(noise.intervals(transition), ((0, fill + 1), (0, 0))),
        np.array([noise.first, noise.ripple]),
        levels**2,
    )
    products = np.asarray(products)[:, :width, :width]
    return Innovations(products, np.asarray(logs), int(np.isfinite(variance).sum()))
