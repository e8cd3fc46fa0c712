"""From the end of an iteration to a result with its uncertainty."""

import itertools
from dataclasses import replace

import numpy as np

from gyrostat._types import Matrix, Vector
from gyrostat.identify.deterministic import StartValues
from gyrostat.identify.fit import Fit
from gyrostat.identify.least_squares import Solution
from gyrostat.identify.loss import Loss, Quadratic
from gyrostat.identify.observability import observability
from gyrostat.identify.plausibility import fit_warnings
from gyrostat.identify.prediction import SpeedPrediction
from gyrostat.identify.selection import Selection
from gyrostat.identify.statistics import (
    correlation_length,
    crossing_times,
    serial_meat,
    whiteness,
)


def _covariance(solution: Solution, loss: Loss, prior_information: Matrix) -> Matrix:
    """Covariance of an estimate under its loss: formal for the quadratic, sandwich otherwise."""
    if isinstance(loss, Quadratic):
        return solution.covariance()
    rows, residual = solution.jacobian, solution.residual
    score = loss.weight(residual) * residual
    bread = np.linalg.inv(rows.T @ (loss.curvature(residual)[:, None] * rows) + prior_information)
    return bread @ (rows.T @ (score[:, None] ** 2 * rows) + prior_information) @ bread


def _serial_sigma(
    solution: Solution, loss: Loss, prior_information: Matrix, counts: list[int]
) -> Vector:
    """Standard deviations when the residuals of each record are correlated in time."""
    rows, residual = solution.jacobian, solution.residual
    bread = np.linalg.inv(rows.T @ (loss.curvature(residual)[:, None] * rows) + prior_information)
    scores = (loss.weight(residual) * residual)[:, None] * rows
    meat = prior_information.copy()
    edges = np.cumsum([0, *counts])
    for first, last in itertools.pairwise(edges):
        block = slice(int(first), int(last))
        meat += serial_meat(scores[block], correlation_length(residual[block]))
    return np.sqrt(np.diag(bread @ meat @ bread))


def conclude(
    prediction: SpeedPrediction,
    selection: Selection,
    values: Vector,
    solution: Solution,
    loss: Loss,
    deterministic: StartValues,
    *,
    speed_sigma: float,
    sigma_given: bool,
) -> Fit:
    """Turn the end of a batch iteration into a result.

    Args:
        prediction: records and friction model.
        selection: what was estimated.
        values: all parameters of the prediction, SI.
        solution: of the free parameters.
        loss: of the residuals.
        deterministic: what the records show without iteration.
        speed_sigma: noise the residuals were whitened with, rad/s.
        sigma_given: whether the user stated it.
    """
    records = prediction.records
    predicted = prediction(values)
    assert predicted is not None  # the solution was reached through admissible points
    index = selection.index(prediction)
    prior_information = np.diag(selection.prior.sigma**-2.0)
    covariance = _covariance(solution, loss, prior_information)
    speeds = tuple(speed for speed, _ in predicted)
    spread = tuple(
        np.sqrt(np.einsum("mi,ij,mj->m", rows[:, index], covariance, rows[:, index]))
        for _, rows in predicted
    )
    counts = [int(r.valid.sum()) for r in records]
    everything = dict(zip(prediction.names, values.tolist(), strict=True))
    crossings = sum(
        len(crossing_times(r.time, s, speed_sigma)) for r, s in zip(records, speeds, strict=True)
    )
    seen = observability(prediction, selection, everything, solution, deterministic, crossings)
    test = whiteness(speed_sigma * solution.residual) if len(solution.residual) >= 10 else None
    serial = _serial_sigma(solution, loss, prior_information, counts)
    fit = Fit(
        model=prediction.model,
        method="batch",
        names=selection.free,
        dimensions=prediction.dimensions,
        values=values[index],
        covariance=covariance,
        serial_sigma=serial,
        held={n: v for n, v in everything.items() if n not in selection.free},
        observability=seen,
        converged=solution.converged,
        iterations=solution.iterations,
        samples=sum(counts),
        crossings=crossings,
        speed_sigma=speed_sigma,
        records=records,
        predicted=speeds,
        predicted_sigma=spread,
        whiteness=test,
    )
    return replace(fit, warnings=tuple(fit_warnings(fit, sigma_given)))
