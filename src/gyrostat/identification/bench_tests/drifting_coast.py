"""Viscous and Coulomb friction of coasts while friction drifts."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.bench.coast import Coast, slowing_speed
from gyrostat.identification.fit.least_squares import Evaluation, Prior, minimise
from gyrostat.identification.fit.loss import Quadratic
from gyrostat.identification.read.statistics import NUMERICAL_NOISE
from gyrostat.identification.uncertainty.sigmas import serial_sigma, widened
from gyrostat.telemetry.signals import scatter


def drifting_coast(
    coasts: Sequence[Coast], start: float, end: float, ratios: Vector, drift: float
) -> tuple[Vector, Matrix] | None:
    """Fit coasts of a record in which friction grows linearly from mid-record to its end.

    J dw/dt = -(1 + d s(t)) (b w + c), with s from -1 to 1 over the record, has the closed solution
    without drift at the time u = t + d times the integral of s. The drift d is estimated with b/J,
    c/J and the initial speeds, from its prior standard deviation.

    Args:
        coasts: Coasts of the record.
        start: First time of the record, s.
        end: Last time, s.
        ratios: Start values of b/J, 1/s, and c/J, rad/s², (2,).
        drift: Standard deviation of d, above 0.

    Returns:
        b/J and c/J, (2,), and their covariance, (2, 2), with serially correlated residuals; None
        if no fit converges.
    """
    from scipy.optimize import leastsq  # slow to import

    middle, half = 0.5 * (start + end), 0.5 * (end - start)
    level = max(float(np.max(coast.speed)) for coast in coasts)
    noise = float(np.median([scatter(coast.speed) for coast in coasts]))
    noise = max(noise, NUMERICAL_NOISE * level)
    # integrals of s from the start of each coast
    sums = [((c.start - middle) * c.time + 0.5 * c.time**2) / half for c in coasts]

    def evaluate(x: Vector) -> Evaluation:
        viscous, coulomb, growth = x[0], x[1], drift * x[-1]
        residuals, blocks = [], []
        for k, (coast, share) in enumerate(zip(coasts, sums, strict=True)):
            time = coast.time + growth * share
            speed, slopes = slowing_speed(time, x[2 + k], viscous, coulomb)
            block = np.zeros((len(time), len(x)))
            block[:, [0, 1, 2 + k]] = slopes
            block[:, -1] = -drift * share * (viscous * speed + coulomb)
            residuals.append((coast.speed - speed) / noise)
            blocks.append(block / noise)
        prior = np.zeros((1, len(x)))
        prior[0, -1] = 1.0
        return np.concatenate([*residuals, [-x[-1]]]), np.vstack([*blocks, prior])

    first = np.array([*ratios, *(float(c.speed[0]) for c in coasts), 0.0])
    # b, c and d of one coast form a narrow curved valley, which full steps leave
    size = np.maximum(np.linalg.norm(evaluate(first)[1], axis=0), 1e-300)
    damped = leastsq(
        lambda x: evaluate(x / size)[0],
        first * size,
        Dfun=lambda x: -evaluate(x / size)[1] / size,
    )[0]
    solution = minimise(evaluate, damped / size, Prior.unknown(len(first)), Quadratic())
    if solution is None or not solution.converged:
        return None
    counts = [len(coast.time) for coast in coasts]
    freedom = max(sum(counts) - len(first) + 1, 1)
    spread = max(1.0, float(solution.residual @ solution.residual) / freedom)
    covariance = spread * solution.covariance()
    sigma = serial_sigma(solution, [*counts, 1], np.sqrt(np.diag(covariance)))
    return solution.x[:2], widened(covariance, sigma)[:2, :2]
