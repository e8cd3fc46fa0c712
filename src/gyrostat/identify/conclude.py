"""From the end of an iteration to a result with its uncertainty."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gyrostat.identify.deterministic import StartValues
from gyrostat.identify.fit import Fit
from gyrostat.identify.loss import Loss
from gyrostat.identify.observability import observability
from gyrostat.identify.plausibility import Scatter, fit_warnings
from gyrostat.identify.prediction import SpeedPrediction
from gyrostat.identify.selection import Selection
from gyrostat.identify.stages import Outcome
from gyrostat.identify.statistics import crossing_times, whiteness
from gyrostat.identify.uncertainty import covariance, residual_levels, serial_sigma


def conclude(
    prediction: SpeedPrediction,
    selection: Selection,
    outcome: Outcome,
    loss: Loss,
    deterministic: StartValues,
    *,
    speed_sigmas: Sequence[float],
    noise: Sequence[float],
    sigma_given: bool,
) -> Fit:
    """Turn the end of a batch iteration into a result.

    Args:
        prediction: records and friction model.
        selection: what was estimated.
        outcome: of the iteration.
        loss: of the residuals.
        deterministic: what the records show without iteration.
        speed_sigmas: noise that the residuals of each record were whitened with, rad/s.
        noise: of each record, as its speed alone shows it, rad/s.
        sigma_given: whether the user stated the noise.
    """
    records, values, solution = prediction.records, outcome.values, outcome.solution
    predicted = prediction(values)
    assert predicted is not None  # the solution was reached through admissible points
    index = selection.index(prediction)
    formal = covariance(solution, loss, selection.prior)
    speeds = tuple(speed for speed, _ in predicted)
    spread = tuple(
        np.sqrt(np.einsum("mi,ij,mj->m", rows[:, index], formal, rows[:, index]))
        for _, rows in predicted
    )
    counts = [int(r.valid.sum()) for r in records]
    everything = dict(zip(prediction.names, values.tolist(), strict=True))
    crossings = sum(
        len(crossing_times(r.time, speed, sigma))
        for r, speed, sigma in zip(records, speeds, speed_sigmas, strict=True)
    )
    fit = Fit(
        model=prediction.model,
        method="batch",
        names=selection.free,
        dimensions=prediction.dimensions,
        values=values[index],
        covariance=formal,
        serial_sigma=serial_sigma(
            solution, loss, selection.prior, counts, np.sqrt(np.diag(formal))
        ),
        held={n: v for n, v in everything.items() if n not in selection.free},
        observability=observability(
            prediction, selection, everything, solution, deterministic, crossings
        ),
        converged=solution.converged,
        iterations=solution.iterations,
        samples=sum(counts),
        crossings=crossings,
        speed_sigma=float(np.sqrt(np.average(np.square(speed_sigmas), weights=counts))),
        speed_sigmas=tuple(speed_sigmas),
        records=records,
        predicted=speeds,
        predicted_sigma=spread,
        whiteness=whiteness(solution.residual) if len(solution.residual) >= 10 else None,
    )
    left = [residual[r.valid] for r, residual in zip(records, fit.residuals, strict=True)]
    levels = residual_levels(left, len(fit.names), loss)
    stated = speed_sigmas if sigma_given else [None] * len(records)
    parts = zip(records, levels, stated, noise, strict=True)
    scatter = [Scatter(r.name, level, given, own) for r, level, given, own in parts]
    return replace(fit, warnings=tuple(fit_warnings(fit, solution.reason, scatter)))
