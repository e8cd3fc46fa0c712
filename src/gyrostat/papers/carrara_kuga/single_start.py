"""The plain iteration that the paper describes: undamped, one start, nothing that notices sticking.

Carrara and Kuga, eqs. (10)-(14), iterated on the correction. The derivatives here pass through the
zero crossings with the jump that eq. (5) leaves out, so a failure is not that omission's.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import solve_triangular

from gyrostat._jax import jax, jnp
from gyrostat.identify.least_squares import triangularise
from gyrostat.papers.carrara_kuga.printed import INERTIA, SPEED_SIGMA, START, Column
from gyrostat.papers.carrara_kuga.virtual_bench import PRIOR_SIGMA, at_noise_level
from gyrostat.telemetry import Record
from gyrostat.wheel import speed_response

MOST_CORRECTIONS = 30
NEGLIGIBLE = 1e-3
"""Standard deviations: a correction this small ends the iteration."""
START_WITHOUT_STRIBECK = (*START[:3], START[2])
"""Eq. (15) with x5 = x4, that is T_s = c, in its units."""


def _respond(x, time, current):
    speed, _ = speed_response(Column(*(INERTIA * x)).wheel(), time, current, 0.0)
    return speed, speed


_differentiate = jax.jit(jax.jacfwd(_respond, has_aux=True))


def plain_iteration_succeeds(record: Record, start: Sequence[float]) -> bool:
    """Whether undamped Gauss-Newton ends with a residual at the level of the noise.

    Args:
        record: to fit.
        start: x2..x5, in the units of eq. (15); the a-priori stays that of eq. (15).
    """
    x, mean, sigma = np.array(start), np.array(START), np.array(PRIOR_SIGMA)
    for _ in range(MOST_CORRECTIONS):
        jacobian, speed = _differentiate(jnp.asarray(x), record.time, record.current)
        residual = record.speed - np.asarray(speed)
        rows = np.vstack([np.diag(1.0 / sigma), np.asarray(jacobian) / SPEED_SIGMA])
        right = np.concatenate([(mean - x) / sigma, residual / SPEED_SIGMA])
        if not np.isfinite(rows).all() or not np.isfinite(right).all():
            return False
        triangle, projected = triangularise(rows, right)
        if np.linalg.norm(projected) < NEGLIGIBLE:
            return at_noise_level(residual)
        x = x + solve_triangular(triangle, projected)
    return False
