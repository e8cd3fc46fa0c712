"""Estimate averaged over effects outside the friction model, linearised at given values."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.loss import Loss
from gyrostat.identification.fit.prediction import Linearisation, SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.selection import Selection
from gyrostat.identification.fit.stages import Outcome
from gyrostat.identification.read.findings import Finding, Score
from gyrostat.identification.uncertainty.averaging import Effect, average
from gyrostat.identification.uncertainty.candidates import candidates
from gyrostat.identification.uncertainty.corrections import Correction, corrections
from gyrostat.identification.uncertainty.effects import nuisances, resolution
from gyrostat.identification.uncertainty.hypotheses import Segment
from gyrostat.identification.uncertainty.sigmas import covariance
from gyrostat.identification.uncertainty.torque_noise import torque_noise
from gyrostat.identification.unknowns import Unknowns


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
    at: Estimate,
    loss: Loss,
    sigmas: Sequence[float],
    unknowns: Unknowns,
    known: Mapping[str, Correction],
) -> Estimate:
    """Average over effects outside the model; `at` if the averaged estimate is not valid.

    Args:
        problem: What was asked.
        prediction: Records and friction model.
        selection: Estimated parameters and a-priori knowledge.
        at: Values at which it is linearised, with the covariance of least squares.
        loss: Loss of the residuals.
        sigmas: Noise of the speed of each record, rad/s.
        unknowns: What the samples leave unknown.
        known: Corrections of the current in the prediction, by effect.
    """
    index, linear = selection.index(prediction), at.linear
    parameters = dict(zip(prediction.names, at.values.tolist(), strict=True))
    formal = dict(zip(selection.free, np.sqrt(np.diag(at.covariance)).tolist(), strict=True))
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
        at.predicted,
        sigmas,
        unknowns.rounding,
        unknowns.repeated,
        unknowns.speed_sigmas,
        strict=True,
    )
    for record, each, predicted, sigma, rounding, repeated, smallest in parts:
        residual = np.where(record.valid, record.speed - each.speed, np.nan)
        # what the effects explain is no outlier
        unexplained = np.where(record.valid, record.speed - predicted, 0.0)
        # a wheel at rest has no error
        shared = np.where(record.speed == 0.0, 1.0, repeated)
        segments.append(
            Segment(
                residual=residual,
                rows=each.jacobian[:, index],
                linear=each,
                noise=torque_noise(prediction, record, each, parameters, rounding),
                sigma=sigma,
                weight=loss.weight(unexplained / sigma) / shared,
                samples=float(np.sum(1.0 / repeated[record.valid])),
                smallest=smallest,
            )
        )
    x = at.values[index]
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
        return at
    # a corrected effect is present by assumption: its probability is that before
    posteriors = tuple(
        replace(e, probability=known[e.name].probability) if e.name in known else e
        for e in mixture.effects
    )
    values = at.values.copy()
    values[index] = x + mixture.shift
    final = prediction.linearise(values)
    if final is None or prediction.stuck([(s.speed, s.jacobian) for s in final], sigmas):
        return replace(
            at,
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
