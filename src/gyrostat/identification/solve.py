"""Solution of a problem of batch identification: nonlinear least squares on the speed.

If the wheel model can stick, the cost has more than one minimum. If the first start value leads to
a result that does not explain the records, other start values are tried and the best result is
kept.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.conclude import conclude
from gyrostat.identification.fit.loss import Loss, loss_named
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.selection import Selection, check_start, select
from gyrostat.identification.fit.stages import Measurements, Outcome, Progress, run_stages
from gyrostat.identification.fit.start_values import integral_regression
from gyrostat.identification.read.checks import check_excitation, check_sigma, check_signals, place
from gyrostat.identification.read.signs import lost_sign
from gyrostat.identification.read.statistics import NUMERICAL_NOISE, noise_level, whiteness
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.rounds import at_residual_level, average_in_rounds
from gyrostat.identification.uncertainty.posterior import sample_posterior
from gyrostat.identification.uncertainty.sigmas import FEW, residual_levels
from gyrostat.identification.uncertainty.tolerances import check_tolerances
from gyrostat.identification.unknowns import Unknowns
from gyrostat.telemetry import cut, pool
from gyrostat.wheel.friction_laws import friction_law

DEFAULT_ITERATIONS = 50
RESTARTS = ((1.0, 0.9), (1.0, 0.7), (2.0, 1.0))
"""Factors on the start values of motor constant and friction torques. A wheel that turns more
easily than the real one still moves whenever the records do."""
EXCESS = 1.25
"""Rms residual over noise above which a result does not explain its records."""
EXPLAINED = 0.7
"""Rms residual over noise below which patterns in the residuals are ignored."""
CHANCE = 1e-4
"""P-value below which a pattern in the residuals is not attributed to chance."""
LONG = 50_000
"""Number of samples above which the second start is the last one, which bounds the time."""
SHOWN = 3000
"""Number of samples that show the pattern of a wrong minimum. Weaker patterns, which longer records
reveal, come from the wheel or from pooled samples that share their ends."""


def _speed_sigmas(
    speed_sigma: float | Sequence[float] | None, count: int
) -> tuple[float, ...] | None:
    """Stated noise of each record, rad/s, or None."""
    if speed_sigma is None:
        return None
    sigmas = np.atleast_1d(np.asarray(speed_sigma, dtype=float)).tolist()
    for sigma in sigmas:
        check_sigma(sigma)
    if len(sigmas) not in (1, count):
        raise InputError(f"speed sigma: found {len(sigmas)} values, expected 1 or {count}")
    return tuple(sigmas * count if len(sigmas) == 1 else sigmas)


def _explains(outcome: Outcome, measure: Measurements, loss: Loss, noise: Sequence[float]) -> bool:
    """Whether the residuals are only noise, of the level found in the records, rad/s."""
    parts = measure.by_record(outcome.solution.residual)
    levels = residual_levels(parts, len(outcome.solution.x), loss)
    if not outcome.solution.converged or max(levels) > EXCESS:
        return False
    ratios = [k * sigma / n for k, sigma, n in zip(levels, measure.sigmas, noise, strict=True) if n]
    residual = outcome.solution.residual
    if len(residual) < FEW or max(ratios, default=0.0) < EXPLAINED:
        return True
    test = whiteness(residual, power=SHOWN)
    return min(test.runs_probability, test.ljung_box_probability) > CHANCE


def _starts(selection: Selection, prediction: SpeedPrediction) -> Iterator[Selection]:
    """The requested start, the start values from the records, and variations of them."""
    yield selection
    fallback = replace(selection, values=selection.fallback, told=frozenset())
    if not np.array_equal(selection.values, fallback.values):
        yield fallback
    for motor, torque in RESTARTS:
        factor = {"motor_constant": motor, "torque": torque}
        factors = [
            factor.get(dimension, 1.0) if name in selection.free else 1.0
            for name, dimension in prediction.dimensions.items()
        ]
        yield replace(fallback, values=fallback.values * factors)


def _search(
    selection: Selection,
    measure: Measurements,
    loss: Loss,
    max_iterations: int,
    noise: Sequence[float],
    on_progress: Progress | None,
) -> Outcome | None:
    """Best result of all starts tried; None if the modelled wheel sticks for each of them."""

    def rank(outcome: Outcome) -> float:
        # of two equally good minima, prefer the one that converged
        return outcome.solution.cost + (not outcome.solution.converged)

    best: Outcome | None = None
    for first in _starts(selection, measure.prediction):
        outcome = run_stages(first, measure, loss, max_iterations, on_progress)
        if outcome is None:
            continue
        last = best is not None and len(outcome.solution.residual) > LONG
        if best is None or rank(outcome) < rank(best):
            best = outcome
        if last or _explains(outcome, measure, loss, noise):
            break
    return best


def solve_as_sampled(
    problem: Problem,
    *,
    on_progress: Progress | None = None,
    on_draws: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Solve a problem with one friction model.

    Args:
        problem: The problem.
        on_progress: As for `identify`.
        on_draws: As for `identify`.

    Returns:
        The fit; `converged` says whether it is valid.

    Raises:
        InputError: The problem or its records do not allow an estimate.
    """
    pooled = [pool(cut(record)) for record in problem.records]
    records = tuple(record for record, _ in pooled)
    loss = loss_named(problem.loss)
    sigmas = _speed_sigmas(problem.speed_sigma, len(records))
    if sigmas is not None:
        sigmas = tuple(s / np.sqrt(size) for s, (_, size) in zip(sigmas, pooled, strict=True))
    prediction = SpeedPrediction(records, friction_law(problem.model), problem.current_hold)
    check_signals(records)
    deterministic = integral_regression(records)
    selection = select(prediction, deterministic, problem)
    check_start(prediction, selection)
    tolerances = check_tolerances(problem.tolerance, selection.free)
    noise = [noise_level(r.speed[r.valid]) for r in records]
    check_excitation(records, prediction.model, selection.free, noise)
    smallest = NUMERICAL_NOISE * deterministic.speed_level
    measure = Measurements(prediction, sigmas or [max(n, smallest) for n in noise])
    unknowns = Unknowns.of(problem, records, prediction.model)
    limit = DEFAULT_ITERATIONS if problem.max_iterations is None else problem.max_iterations

    best = _search(selection, measure, loss, limit, noise, on_progress)
    if best is None:
        findings = [finding for r in records if (finding := lost_sign(r)) is not None]
        if findings:
            raise InputError(
                f"{place(records)}: found a {findings[0].titles[0]}, expected a signed one; "
                f"{findings[0].options[0]} restores it"
            )
        raise InputError(
            f"{place(records)}: found no start from which the modelled wheel turns as the record "
            "does, expected start or held values closer to this wheel"
        )
    if sigmas is None:
        measure, best = at_residual_level(selection, measure, best, loss, limit, smallest)
        levels = [max(n, smallest, s) for n, s in zip(noise, unknowns.speed_sigmas, strict=True)]
    else:
        levels = np.hypot(sigmas, unknowns.speed_sigmas).tolist()
    result = average_in_rounds(
        problem, selection, measure, best, loss, levels, unknowns, limit, smallest
    )
    fit = conclude(
        problem, selection, result, loss, deterministic, noise=noise, tolerances=tolerances
    )
    if not (problem.posterior and fit.converged):
        return fit
    places = [fit.names.index(name) for name in selection.free]
    posterior = sample_posterior(
        result.prediction,
        selection.free,
        fit.parameters,
        fit.covariance[np.ix_(places, places)],
        selection.prior,
        result.measure.sigmas,
        () if problem.white_noise else fit.effects,
        errors=() if problem.white_noise else unknowns.errors,
        rounding=unknowns.rounding,
        on_progress=on_draws,
    )
    return replace(fit, posterior=posterior)
