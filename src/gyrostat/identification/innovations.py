"""Prediction errors of a linearised record under random torques: a Kalman filter in O(N).

The speed error x of a wheel and a random-walk torque u obey, from sample to sample,
    x' = f x + g u + v,   u' = u + w,   r = S theta + x + e,
with the transition f and the gain g of each interval of the exact prediction. One filter serves
all columns of [r, S] (its gains do not depend on the data), and many noise levels at once. The sums
of squares and products of the whitened columns are sufficient for a linear regression: they give
the likelihood of every hypothesis in closed form (Harvey 1989, "Forecasting, structural time series
models and the Kalman filter", sections 3.4 and 3.7).
"""

from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.stored_function import stored_function
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.effects import TorqueNoise, spare
from gyrostat.identification.prediction import padded


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
def _filter(columns, variance, transition, gain, crossing, walk, first, squared):
    """Whiten columns (N, c) for g noise levels; `squared` holds the squared levels, (g, 2)."""
    levels, count = squared.shape[0], columns.shape[1]

    def sample(carry, entry):
        state, xx, xu, uu, products, logs = carry
        row, noise, f, g, v, w = entry
        error = row - state[:, 0]
        total = xx + noise
        used = jnp.isfinite(noise)
        weight = jnp.where(used, 1.0 / total, 0.0)
        products = products + error[:, :, None] * (error * weight[:, None])[:, None, :]
        logs = logs + jnp.where(used, jnp.log(total), 0.0)
        kx, ku = xx * weight, xu * weight
        x, u = state[:, 0] + kx[:, None] * error, state[:, 1] + ku[:, None] * error
        xx, xu, uu = xx - kx * xx, xu - kx * xu, uu - ku * xu
        state = jnp.stack([f * x + g * u, u], axis=1)
        ahead = f * f * xx + 2.0 * f * g * xu + g * g * uu + v * squared[:, 0]
        return (state, ahead, f * xu + g * uu, uu + w * squared[:, 1], products, logs), None

    nothing = jnp.zeros(levels)
    start = (
        jnp.zeros((levels, 2, count)),
        nothing,
        nothing,
        first * squared[:, 1],
        jnp.zeros((levels, count, count)),
        nothing,
    )
    last, _ = jax.lax.scan(sample, start, (columns, variance, transition, gain, crossing, walk))
    return last[4], last[5]


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
        padded(np.append(transition, 0.0)),
        padded(np.append(noise.gain, 0.0)),
        padded(np.append(noise.crossings, 0.0)),
        padded(np.append(noise.walk, 0.0)),
        noise.first,
        levels**2,
    )
    products = np.asarray(products)[:, :width, :width]
    return Innovations(products, np.asarray(logs), int(np.isfinite(variance).sum()))
