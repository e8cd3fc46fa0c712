"""Build the result and its uncertainty from a finished iteration."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.identification.fit.loss import Loss
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.selection import Selection
from gyrostat.identification.fit.start_values import StartValues
from gyrostat.identification.judge.faults import found_in
from gyrostat.identification.judge.plausibility import Scatter, judged
from gyrostat.identification.read.statistics import crossing_times, whiteness
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.rounds import Averaged
from gyrostat.identification.uncertainty.feedback import Feedback, feedback_in
from gyrostat.identification.uncertainty.observability import Observability, observability
from gyrostat.identification.uncertainty.sigmas import residual_levels, widened
from gyrostat.identification.uncertainty.tolerances import Propagated, propagate
from gyrostat.telemetry import Record

UNJUDGED = (
    "effects outside the friction model could not be estimated (the wheel corrected for them does "
    "not follow the record): sigma is that of white noise alone and may be far too small"
)


def conclude(
    problem: Problem,
    selection: Selection,
    result: Averaged,
    loss: Loss,
    deterministic: StartValues,
    *,
    noise: Sequence[float],
    tolerances: Mapping[str, float],
) -> Fit:
    """Build the result from the end of a batch iteration.

    Args:
        problem: What was asked.
        selection: Estimated parameters and a-priori knowledge.
        result: Least squares and the average around it.
        loss: Loss of the residuals.
        deterministic: Start values from the records alone.
        noise: Noise of each record, estimated from its speed alone, rad/s.
        tolerances: Name of a given quantity -> relative tolerance, one sigma, validated.
    """
    sigma_given, white_noise = problem.speed_sigma is not None, problem.white_noise
    prediction, outcome, speed_sigmas = result.prediction, result.outcome, result.measure.sigmas
    records, solution, plain, best = prediction.records, outcome.solution, result.plain, result.best
    index, formal = selection.index(prediction), plain.covariance
    wider = widened(best.covariance, np.sqrt(np.diag(formal)))
    counts = [int(r.valid.sum()) for r in records]
    parameters = dict(zip(prediction.names, best.values.tolist(), strict=True))
    crossings = sum(
        len(crossing_times(r.time, speed, sigma))
        for r, speed, sigma in zip(records, plain.predicted, speed_sigmas, strict=True)
    )
    fit = Fit(
        model=prediction.model,
        method="batch",
        names=selection.free,
        dimensions=prediction.dimensions,
        values=best.values[index],
        covariance=wider,
        noise_sigma=np.sqrt(np.diag(formal)),
        least_squares=outcome.values[index],
        held={n: v for n, v in parameters.items() if n not in selection.free},
        observability=observability(
            prediction,
            selection,
            parameters,
            solution,
            deterministic,
            wider,
            formal,
        ),
        converged=solution.converged,
        iterations=solution.iterations,
        samples=sum(counts),
        crossings=crossings,
        speed_sigma=float(np.sqrt(np.average(np.square(speed_sigmas), weights=counts))),
        speed_sigmas=tuple(speed_sigmas),
        records=records,
        predicted=best.predicted,
        predicted_sigma=tuple(
            np.sqrt(np.einsum("mi,ij,mj->m", rows, wider, rows))
            for rows in (each.jacobian[:, index] for each in best.linear)
        ),
        whiteness=whiteness(solution.residual, solution.jacobian)
        if len(solution.residual) >= 10
        else None,
        effects=best.effects,
        findings=best.findings,
        scores=best.scores,
        feedback=_feedback(problem, records),
    )
    if tolerances:
        information = selection.prior.information()
        fit = with_tolerances(
            fit,
            propagate(
                tolerances, prediction, best.linear, best.values, speed_sigmas, index, information
            ),
            tolerances,
        )
    residuals = [r.speed - speed for r, speed in zip(records, plain.predicted, strict=True)]
    valid_residuals = [each[record.valid] for each, record in zip(residuals, records, strict=True)]
    levels = residual_levels(valid_residuals, len(selection.free), loss)
    stated_sigmas = speed_sigmas if sigma_given else [None] * len(records)
    parts = zip(records, levels, stated_sigmas, noise, strict=True)
    scatter = [Scatter(r.name, level, stated, each) for r, level, stated, each in parts]
    silent = best.honest or white_noise or not solution.converged
    faults = [
        f for r, each in zip(records, residuals, strict=True) for f in found_in(r, each, loss)
    ]
    reasons = () if silent else (UNJUDGED,)
    return judged(fit, solution.reason, scatter, faults=faults, refused=reasons)


def _feedback(problem: Problem, records: Sequence[Record]) -> Feedback | None:
    """Feedback in the records, as stated or found; None if white noise is assumed."""
    if problem.loop is not None:
        return Feedback(problem.loop == "closed", None)
    return None if problem.white_noise else feedback_in(records)


def with_tolerances(fit: Fit, errors: Propagated, tolerances: Mapping[str, float]) -> Fit:
    """Add the effect of tolerances to the uncertainty of a fit.

    An inertia with a tolerance is added to the parameters, at its given value: its error is
    correlated with those of the estimates, and wheels drawn from the fit need both.

    Args:
        fit: Fit without tolerances.
        errors: Errors of the estimates caused by the tolerances.
        tolerances: Name -> relative tolerance, one sigma.
    """
    covariance, names = fit.covariance, fit.names
    if "inertia" not in tolerances or "inertia" not in fit.held:
        return replace(fit, covariance=covariance + errors.covariance(), tolerances=errors)
    inertia = fit.held["inertia"]
    row = np.where(np.array(errors.names) == "inertia", tolerances["inertia"] * inertia, 0.0)
    errors = replace(errors, roots=np.vstack([errors.roots, row]))
    size = len(names)
    every = errors.covariance()
    every[:size, :size] += covariance
    return replace(
        fit,
        names=(*names, "inertia"),
        values=np.append(fit.values, inertia),
        covariance=every,
        noise_sigma=np.append(fit.noise_sigma, 0.0),
        least_squares=np.append(fit.least_squares, inertia),
        held={n: v for n, v in fit.held.items() if n != "inertia"},
        observability={**fit.observability, "inertia": Observability(False, 0.0, given=True)},
        tolerances=errors,
    )
