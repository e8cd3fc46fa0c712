"""Segments of a speed signal with shared and separate parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.least_squares import Evaluation, Prior, Solution, minimise
from gyrostat.identification.loss import Quadratic
from gyrostat.identification.plausibility import Scatter
from gyrostat.identification.statistics import NUMERICAL_NOISE, whiteness
from gyrostat.identification.uncertainty import serial_sigma

FINEST = 1e-9
"""Smallest level of the whitened residuals."""

Model = Callable[[int, Vector, Vector], tuple[Vector, Matrix]]
"""Index of a segment, common parameters, (c,), and its own, (p,) -> modelled speed, (m,), rad/s,
and its derivatives, (m, c + p)."""


@dataclass(frozen=True)
class StretchFit:
    """Fit of common parameters to several segments of speed.

    Attributes:
        solution: Solution for all parameters, common ones first.
        covariance: Covariance of the common parameters, (c, c).
        serial_sigma: Standard deviations of the common parameters with correlated residuals, (c,).
        speed_sigma: Standard deviation of a speed, as given or from the residuals, rad/s.
        rms: Root mean square of the residuals, rad/s.
    """

    solution: Solution
    covariance: Matrix
    serial_sigma: Vector
    speed_sigma: float
    rms: float

    def outcome(
        self, scale: float, places: list[int], stated: float | None, noise: float, name: str
    ) -> dict[str, Any]:
        """Fields of a result for some common parameters.

        Args:
            scale: Unit of the parameters, SI.
            places: Indices of the parameters among the common ones.
            stated: Noise stated by the user, rad/s, or None.
            noise: Noise estimated from the records, rad/s.
            name: Name of the records.
        """
        return {
            "reason": self.solution.reason,
            "covariance": scale**2 * self.covariance[np.ix_(places, places)],
            "serial_sigma": scale * self.serial_sigma[places],
            "iterations": self.solution.iterations,
            "samples": len(self.solution.residual),
            "speed_sigma": self.speed_sigma,
            "scatter": [Scatter(name, self.rms, stated, noise)],
            "whiteness": whiteness(self.solution.residual, self.solution.jacobian),
        }


def fit_stretches(
    speeds: Sequence[Vector],
    model: Model,
    common: Vector,
    own: Sequence[Vector],
    speed_sigma: float | None,
    noise: float,
) -> StretchFit:
    """Fit a model of the speed to all segments together by nonlinear least squares.

    Args:
        speeds: Measured speed of each segment, (m,), rad/s.
        model: Model of the speed in one segment; all values of its parameters are admissible.
        common: Start values of the common parameters, (c,).
        own: Start values of each segment's own parameters, (p,).
        speed_sigma: Standard deviation of a measured speed, rad/s; None to estimate it from the
            residuals.
        noise: Noise of the speed estimated from the records, rad/s.
    """
    level = max(float(np.max(np.abs(speed))) for speed in speeds)
    sigma = speed_sigma or max(noise, NUMERICAL_NOISE * level)
    shared, size = len(common), len(own[0])

    def evaluate(x: Vector) -> Evaluation:
        residuals, rows = [], []
        for k, measured in enumerate(speeds):
            places = [*range(shared), *range(shared + k * size, shared + (k + 1) * size)]
            speed, slopes = model(k, x[:shared], x[places[shared:]])
            block = np.zeros((len(speed), len(x)))
            block[:, places] = slopes
            residuals.append((measured - speed) / sigma)
            rows.append(block / sigma)
        return np.concatenate(residuals), np.vstack(rows)

    start = np.concatenate([common, *own])
    unknown = Prior.unknown(len(start))
    solution = minimise(evaluate, start, unknown, Quadratic())
    assert solution is not None  # every start is admissible
    misfit = float(solution.residual @ solution.residual)
    spread = 1.0
    if speed_sigma is None:
        freedom = max(len(solution.residual) - len(start), 1)
        spread = max(float(np.sqrt(misfit / freedom)), FINEST)
    covariance = spread**2 * solution.covariance()
    serial = serial_sigma(
        solution, Quadratic(), unknown, [len(s) for s in speeds], np.sqrt(np.diag(covariance))
    )
    return StretchFit(
        solution=solution,
        covariance=covariance[:shared, :shared],
        serial_sigma=serial[:shared],
        speed_sigma=speed_sigma or spread * sigma,
        rms=sigma * float(np.sqrt(misfit / len(solution.residual))),
    )
