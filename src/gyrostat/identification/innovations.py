"""Prediction errors of a linearised record under random torques: a Kalman filter in O(N).

The speed error x of a wheel and a wandering torque u obey, from sample to sample,
    x' = f x + g u + v,   u' = u + w,   r = S theta + x + e,
with the transition f and the gain g of each interval of the exact prediction. One filter serves
all columns of [r, S] (its gains do not depend on the data), and many noise levels at once. The sums
of squares and products of the whitened columns are all that a linear regression needs: with them
the likelihood of every hypothesis has a closed form (Harvey 1989, "Forecasting, structural time
series models and the Kalman filter", sections 3.4 and 3.7).
"""

from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.effects import TorqueNoise, padded, spare


class Innovations(NamedTuple):
    """Whitened columns of one record under each of g noise levels.

    Attributes:
        products: Sums of products of the whitened columns, (g, c, c).
        log_variance: Sum of the logarithms of the variances of the prediction errors, (g,).
        samples: Number of them used.
    """

    products: Vector
    log_variance: Vector
    samples: int

    def leading(self, count: int) -> "Innovations":
        """The same for the first columns alone."""
        return self._replace(products=self.products[:, :count, :count])


@jax.jit
def _filter(columns, variance, transition, gain, crossing, walk, first, squared):
    """Whiten columns (N, c) for g noise levels, whose squares are (g, 2)."""
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
        columns: (N, c) residuals and derivatives of the speed; anything finite where a sample is
            missing.
        variance: (N,) of the measured speed, in the squared unit of the columns; infinite where a
            sample is missing.
        transition: (N - 1,) derivative of the speed at the end of each interval by that at its
            start.
        noise: Random torque at level one, in SI.
        levels: (g, 2) levels of the ripple at crossings and of the wandering torque.
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
