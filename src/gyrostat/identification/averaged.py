"""Estimate averaged over effects outside the friction model, with the current corrected.

The average is linearised at a least-squares fit. Where a record shows an error of its current or a
drift of the friction, the current is corrected
(`gyrostat.identification.uncertainty.corrections`) and the fit is repeated until the corrections no
longer change.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.loss import Loss
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.selection import Selection
from gyrostat.identification.fit.stages import Measurements, Outcome, refine
from gyrostat.identification.read.findings import Finding, Score
from gyrostat.identification.uncertainty.averaging import Effect, average
from gyrostat.identification.uncertainty.candidates import candidates
from gyrostat.identification.uncertainty.corrections import Correction, corrections
from gyrostat.identification.uncertainty.effects import nuisances, resolution
from gyrostat.identification.uncertainty.hypotheses import Segment
from gyrostat.identification.uncertainty.sigmas import covariance, residual_levels
from gyrostat.identification.uncertainty.torque_noise import torque_noise
from gyrostat.identification.unknowns import Unknowns

ROUNDS = 4
"""Largest number of fits with corrected currents."""
SETTLED = 0.02
"""Change of a correction, in prior standard deviations, that is ignored."""
WORSE = 1.5
"""Factor on the sum of squared residuals above which a corrected current explains a record worse
than the recorded one. The linearisation that gave the correction does not hold then."""


@dataclass(frozen=True)
class Estimate:
    """Estimates with their uncertainty.

    Attributes:
        values: All parameters, (p,), SI.
        covariance: Covariance of the n estimated parameters, (n, n), SI.
        predicted: Modelled speed of each record with the effects found, rad/s.
        linear: Linearisation of each record at these values, without effects.
        effects: Posteriors of effects outside the friction model.
        findings: Findings of the diagnosis.
        scores: Score tests of all candidates.
        corrections: Currents that act as the effects that the records show.
        honest: Whether values and covariance are those of the average over the effects.
    """

    values: Vector
    covariance: Matrix
    predicted: tuple[Vector, ...]
    linear: Sequence[Linearisation]
    effects: tuple[Effect, ...] = ()
    findings: tuple[Finding, ...] = ()
    scores: tuple[Score, ...] = ()
    corrections: tuple[Correction, ...] = ()
    honest: bool = False


def plain_estimate(
    prediction: SpeedPrediction, selection: Selection, outcome: Outcome, loss: Loss
) -> Estimate:
    """Estimate of least squares in white noise."""
    linear = prediction.linearise(outcome.values)
    assert linear is not None  # the iteration visits admissible points only
    formal = covariance(outcome.solution, loss, selection.prior)
    return Estimate(outcome.values, formal, tuple(each.speed for each in linear), linear)


def averaged(
    problem: Problem,
    prediction: SpeedPrediction,
    selection: Selection,
    plain: Estimate,
    loss: Loss,
    sigmas: Sequence[float],
    unknowns: Unknowns,
    known: Mapping[str, Correction],
) -> Estimate:
    """Average over effects outside the model; `plain` if the averaged estimate is not valid.

    Args:
        problem: What was asked.
        prediction: Records and friction model.
        selection: Estimated parameters and a-priori knowledge.
        plain: Estimate of least squares.
        loss: Loss of the residuals.
        sigmas: Noise of the speed of each record, rad/s.
        unknowns: What the samples leave unknown.
        known: Corrections of the current in the prediction, by effect.
    """
    index, linear = selection.index(prediction), plain.linear
    parameters = dict(zip(prediction.names, plain.values.tolist(), strict=True))
    formal = dict(zip(selection.free, np.sqrt(np.diag(plain.covariance)).tolist(), strict=True))
    currents = [error.nuisance(prediction, linear) for error in unknowns.errors]
    effects = [*currents, *nuisances(prediction, linear, parameters, formal)]
    further = candidates(prediction, linear, parameters)
    effects += [effect for effect in further if effect.name in problem.include]
    effects = [replace(e, at=known[e.name].at) if e.name in known else e for e in effects]
    beside = [effect for effect in further if effect.name not in problem.include]
    segments = []
    parts = zip(
        prediction.records,
        linear,
        sigmas,
        unknowns.rounding,
        unknowns.repeated,
        unknowns.speed_sigmas,
        strict=True,
    )
    for record, each, sigma, rounding, repeated, smallest in parts:
        residual = np.where(record.valid, record.speed - each.speed, np.nan)
        # a wheel at rest has no error
        shared = np.where(record.speed == 0.0, 1.0, repeated)
        segments.append(
            Segment(
                residual=residual,
                rows=each.jacobian[:, index],
                linear=each,
                noise=torque_noise(prediction, record, each, parameters, rounding),
                sigma=sigma,
                weight=loss.weight(np.nan_to_num(residual) / sigma) / shared,
                samples=float(np.sum(1.0 / repeated[record.valid])),
                smallest=smallest,
            )
        )
    x = plain.values[index]
    try:
        mixture = average(
            segments,
            effects,
            selection.prior,
            x,
            selection.scale,
            stated=problem.speed_sigma is not None,
            beside=beside,
            names=selection.free,
            ripple=problem.ripple,
            resolution=resolution(prediction, parameters, formal),
        )
    except np.linalg.LinAlgError:
        return plain
    # a corrected effect is present by assumption: its probability is that before
    posteriors = tuple(
        replace(e, probability=known[e.name].probability) if e.name in known else e
        for e in mixture.effects
    )
    values = plain.values.copy()
    values[index] = x + mixture.shift
    final = prediction.linearise(values)
    if final is None or prediction.stuck([(s.speed, s.jacobian) for s in final], sigmas):
        return replace(
            plain,
            effects=posteriors,
            findings=mixture.findings,
            scores=mixture.scores,
        )
    speeds = []
    for k, each in enumerate(final):
        columns = [effect.columns[k] for effect in effects]
        speeds.append(each.speed + np.column_stack(columns) @ mixture.coefficients)
    return Estimate(
        values=values,
        covariance=mixture.covariance,
        predicted=tuple(speeds),
        linear=final,
        effects=posteriors,
        findings=mixture.findings,
        scores=mixture.scores,
        corrections=corrections(effects, posteriors, mixture.coefficients),
        honest=True,
    )


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


def average_with_corrections(
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
    """Average over effects, and repeat the fit with corrected currents as long as they change.

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
    diagnosed: dict[str, Any] = {}
    known: dict[str, Correction] = {}
    for rounds in range(ROUNDS + 1):
        best = averaged(problem, prediction, selection, plain, loss, noise, unknowns, known)
        # the diagnosis is that of the record as it was measured
        diagnosed = diagnosed or {"findings": best.findings, "scores": best.scores}
        best = replace(best, **diagnosed)
        result = Averaged(prediction, measure, outcome, plain, best)
        change = [found.change(known.get(found.name)) for found in best.corrections]
        if rounds == ROUNDS or max(change, default=0.0) < SETTLED:
            return result
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
            measure, outcome = at_residual_level(selection, measure, again, loss, limit, smallest)
        plain = plain_estimate(prediction, selection, outcome, loss)
    raise AssertionError
