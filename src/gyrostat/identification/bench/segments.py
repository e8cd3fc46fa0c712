"""Segments of a speed signal with shared and separate parameters."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.least_squares import Evaluation, Prior, minimise
from gyrostat.identification.fit.loss import Quadratic
from gyrostat.identification.judge.plausibility import Scatter
from gyrostat.identification.read.checks import place
from gyrostat.identification.read.statistics import NUMERICAL_NOISE, whiteness
from gyrostat.identification.uncertainty.sigmas import serial_sigma
from gyrostat.telemetry import Record

FINEST = 1e-9
"""Smallest level of the whitened residuals."""

Model = Callable[[int, Vector, Vector], tuple[Vector, Matrix]]
"""Index of a segment, common parameters, (c,), and its own, (p,) -> modelled speed, (m,), rad/s,
and its derivatives, (m, c + p)."""


def fit_stretches(
    speeds: Sequence[Vector],
    model: Model,
    common: Vector,
    own: Sequence[Vector],
    *,
    records: tuple[Record, ...],
    speed_sigma: float | None,
    noise: float,
    scale: float,
    count: int,
) -> tuple[Vector, dict[str, Any]]:
    """Fit a model of the speed to all segments together by nonlinear least squares.

    Args:
        speeds: Measured speed of each segment, (m,), rad/s.
        model: Model of the speed in one segment; all values of its parameters are admissible.
        common: Start values of the common parameters, (c,).
        own: Start values of each segment's own parameters, (p,).
        records: Records of the segments.
        speed_sigma: Standard deviation of a measured speed, rad/s; None to estimate it from the
            residuals.
        noise: Noise of the speed estimated from the records, rad/s.
        scale: Unit of the estimates, SI.
        count: Number of common parameters that are estimates; they come first.

    Returns:
        The estimates, (count,), SI, and further arguments of `bench_methods.result`.
    """
    level = max(float(np.max(np.abs(speed))) for speed in speeds)
    sigma = speed_sigma or max(noise, NUMERICAL_NOISE * level)
    offset, size = len(common), len(own[0])

    def evaluate(x: Vector) -> Evaluation:
        residuals, rows = [], []
        for k, measurement in enumerate(speeds):
            places = [*range(offset), *range(offset + k * size, offset + (k + 1) * size)]
            speed, slopes = model(k, x[:offset], x[places[offset:]])
            block = np.zeros((len(speed), len(x)))
            block[:, places] = slopes
            residuals.append((measurement - speed) / sigma)
            rows.append(block / sigma)
        return np.concatenate(residuals), np.vstack(rows)

    start = np.concatenate([common, *own])
    solution = minimise(evaluate, start, Prior.unknown(len(start)), Quadratic())
    assert solution is not None  # every start is admissible
    misfit = float(solution.residual @ solution.residual)
    spread = 1.0
    if speed_sigma is None:
        freedom = max(len(solution.residual) - len(start), 1)
        spread = max(float(np.sqrt(misfit / freedom)), FINEST)
    covariance = spread**2 * solution.covariance()
    formal = np.sqrt(np.diag(covariance))
    serial = serial_sigma(solution, [len(speed) for speed in speeds], formal)
    rms = sigma * float(np.sqrt(misfit / len(solution.residual)))
    return scale * solution.x[:count], {
        "records": records,
        "reason": solution.reason,
        "covariance": scale**2 * covariance[:count, :count],
        "serial_sigma": scale * serial[:count],
        "iterations": solution.iterations,
        "samples": len(solution.residual),
        "speed_sigma": speed_sigma or spread * sigma,
        "scatter": [Scatter(place(records), rms, speed_sigma, noise)],
        "whiteness": whiteness(solution.residual, solution.jacobian),
    }
