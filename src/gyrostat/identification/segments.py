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
"""Place of a stretch, (c,) common and (p,) own parameters -> modelled speed, (m,) rad/s, and its
derivatives, (m, c + p)."""


@dataclass(frozen=True)
class StretchFit:
    """Common parameters of stretches of speed.

    Attributes:
        solution: of all parameters, common ones first.
        covariance: of the common ones, (c, c).
        serial_sigma: their standard deviations that allow for correlated residuals, (c,).
        speed_sigma: standard deviation of a speed, rad/s: as given, or from the residuals.
        rms: of the residuals, rad/s.
    """

    solution: Solution
    covariance: Matrix
    serial_sigma: Vector
    speed_sigma: float
    rms: float

    def outcome(
        self, scale: float, places: list[int], stated: float | None, noise: float, name: str
    ) -> dict[str, Any]:
        """What a result says of some common parameters.

        Args:
            scale: unit of the parameters, SI.
            places: of the parameters among the common ones.
            stated: noise that the user stated, rad/s, or None.
            noise: that the records show, rad/s.
            name: of the records.
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
    """Fit a model of the speed to all stretches at once by nonlinear least squares.

    Args:
        speeds: measured, (m,) rad/s each.
        model: of the speed in one stretch; every value of its parameters is admissible.
        common: (c,) first values of what all stretches share.
        own: (p,) first values of what each has for itself.
        speed_sigma: standard deviation of a measured speed, rad/s, otherwise from the residuals.
        noise: of the speed, as the records show it, rad/s.
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
