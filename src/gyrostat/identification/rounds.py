"""Rounds of the average over effects: at the motion that the effects cause.

The average over effects is linear, the motion is not: a static torque that is wrong by half, or a
drift that the fit does not have, shifts the zero crossings, and what a static torque does there is
not what it does in the real motion. The first average is linearised at the least-squares fit, each
further one at the average before it (as an iterated Kalman filter: Bell and Cathey 1993, IEEE
Transactions on Automatic Control 38). Where a record shows an error of its current or a drift of
the friction, the current is corrected (`gyrostat.identification.uncertainty.corrections`) and the
fit is repeated too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.averaged import Estimate, averaged, plain_estimate
from gyrostat.identification.fit.loss import Loss
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.selection import Selection
from gyrostat.identification.fit.stages import Measurements, Outcome, refine
from gyrostat.identification.uncertainty.corrections import Correction
from gyrostat.identification.uncertainty.sigmas import residual_levels
from gyrostat.identification.unknowns import Unknowns

ROUNDS = 8
"""Largest number of further rounds."""
SETTLED = 0.02
"""Change of a correction, in prior standard deviations, that is ignored."""
NEAR = 0.1
"""Distance of an average from its linearisation, in standard deviations, that is ignored."""
WORSE = 1.5
"""Factor on the sum of squared residuals above which a corrected current explains a record worse
than the recorded one. The linearisation that gave the correction does not hold then."""


@dataclass(frozen=True)
class Averaged:
    """Least squares and the average around it, at the last corrections of the current.

    Attributes:
        prediction: Prediction with the corrected currents.
        measure: Whitened residuals of it.
        outcome: Least squares.
        plain: Estimate of least squares.
        best: Averaged estimate; `plain` if there is none.
    """

    prediction: SpeedPrediction
    measure: Measurements
    outcome: Outcome
    plain: Estimate
    best: Estimate


def at_residual_level(
    selection: Selection,
    measure: Measurements,
    outcome: Outcome,
    loss: Loss,
    limit: int,
    smallest: float,
) -> tuple[Measurements, Outcome]:
    """Fit once more with the noise of each record that its residuals show.

    Args:
        selection: Estimated parameters and a-priori knowledge.
        measure: Whitened residuals.
        outcome: End of the iteration.
        loss: Loss of the residuals.
        limit: Largest number of corrections, with those before.
        smallest: Smallest noise of the speed, rad/s.
    """
    parts = measure.by_record(outcome.solution.residual)
    levels = residual_levels(parts, len(outcome.solution.x), loss)
    pairs = zip(levels, measure.sigmas, strict=True)
    final = Measurements(measure.prediction, [max(level * s, smallest) for level, s in pairs])
    last = refine(selection, final, outcome.values, loss, limit, outcome.solution.iterations)
    return (measure, outcome) if last is None else (final, last)


def _explains_no_worse(corrected: Outcome, recorded: Outcome) -> bool:
    """Whether a fit with corrected currents is valid, and as good as that before."""
    fit = corrected.solution
    return fit.converged and fit.cost <= WORSE * recorded.solution.cost


def _next(prediction: SpeedPrediction, selection: Selection, best: Estimate) -> Vector:
    """Values of the next linearisation: those of an average, with no static torque below Coulomb.

    No wheel has one: there, the modelled motion says nothing of a real one.
    """
    values = dict(zip(prediction.names, best.values.tolist(), strict=True))
    for name, reference in prediction.model.vanishing_at.items():
        if name in selection.free:
            values[name] = max(values[name], values[reference])
    return np.array([values[name] for name in prediction.names])


def average_in_rounds(
    problem: Problem,
    selection: Selection,
    measure: Measurements,
    outcome: Outcome,
    loss: Loss,
    noise: Sequence[float],
    unknowns: Unknowns,
    limit: int,
    smallest: float,
) -> Averaged:
    """Average over effects, linearised at the average, with the fit repeated at corrected currents.

    Args:
        problem: What was asked.
        selection: Estimated parameters and a-priori knowledge.
        measure: Whitened residuals.
        outcome: End of the iteration.
        loss: Loss of the residuals.
        noise: Noise of the speed of each record for the average, rad/s.
        unknowns: What the samples leave unknown.
        limit: Largest number of corrections of a fit.
        smallest: Smallest noise of the speed, rad/s.
    """
    prediction = measure.prediction
    plain = plain_estimate(prediction, selection, outcome, loss)
    if problem.white_noise or not outcome.solution.converged:
        return Averaged(prediction, measure, outcome, plain, plain)
    index = selection.index(prediction)
    diagnosed: dict[str, Any] = {}
    known: dict[str, Correction] = {}
    at = plain
    for rounds in range(ROUNDS + 1):
        best = averaged(problem, prediction, selection, at, loss, noise, unknowns, known)
        lost = not best.honest
        if lost and at is not plain:
            best = averaged(problem, prediction, selection, plain, loss, noise, unknowns, known)
        values = _next(prediction, selection, best)
        moved = (values - at.values)[index]
        near = lost or np.max(np.abs(moved) / np.sqrt(np.diag(best.covariance))) < NEAR
        if rounds == ROUNDS and not near:  # where it would settle is not known better than this
            best = replace(best, covariance=best.covariance + np.outer(moved, moved))
        # the diagnosis is that of the record as it was measured
        diagnosed = diagnosed or {"findings": best.findings, "scores": best.scores}
        best = replace(best, **diagnosed)
        result = Averaged(prediction, measure, outcome, plain, best)
        change = [found.change(known.get(found.name)) for found in best.corrections]
        settled = max(change, default=0.0) < SETTLED
        if rounds == ROUNDS or (settled and near):
            return result
        if not settled:
            known = {found.name: found for found in best.corrections}
            added = zip(*(found.currents for found in best.corrections), strict=True)
            prediction = SpeedPrediction(
                prediction.records,
                prediction.model,
                prediction.hold,
                [np.sum(currents, axis=0) for currents in added],
            )
            measure = Measurements(prediction, measure.sigmas)
            again = refine(selection, measure, best.values, loss, limit, 0)
            if again is None or not _explains_no_worse(again, outcome):
                shown = {"effects": best.effects, "findings": best.findings, "scores": best.scores}
                return replace(result, best=replace(plain, **shown))
            outcome = again
            if problem.speed_sigma is None:
                measure, outcome = at_residual_level(
                    selection, measure, again, loss, limit, smallest
                )
            plain = plain_estimate(prediction, selection, outcome, loss)
        linear = prediction.linearise(values)
        if linear is None and settled:
            return result
        at = plain
        if linear is not None:
            at = replace(plain, values=values, predicted=best.predicted, linear=linear)
    raise AssertionError
