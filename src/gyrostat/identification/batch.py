"""Batch identification of a wheel from records of current and speed.

If the wheel model can stick, the cost has more than one minimum. If the first start value leads to
a result that does not explain the records, other start values are tried and the best result is
kept.
"""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.automatic import AUTO, identify_automatically
from gyrostat.identification.checks import (
    as_records,
    check_excitation,
    check_sigma,
    check_signals,
    place,
)
from gyrostat.identification.conclude import conclude
from gyrostat.identification.fit import Fit
from gyrostat.identification.loss import Loss, loss_named
from gyrostat.identification.posterior import sample_posterior
from gyrostat.identification.posterior_sampler import check_sampler
from gyrostat.identification.prediction import CurrentHold, SpeedPrediction
from gyrostat.identification.selection import Selection, check_start, select
from gyrostat.identification.signs import lost_sign
from gyrostat.identification.stages import Measurements, Outcome, Progress, refine, run_stages
from gyrostat.identification.start_values import integral_regression
from gyrostat.identification.statistics import NUMERICAL_NOISE, noise_level, whiteness
from gyrostat.identification.tolerances import check_tolerances
from gyrostat.identification.uncertainty import FEW, residual_levels
from gyrostat.telemetry import Record, cut, pool
from gyrostat.wheel.friction_laws import Law, friction_law

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


def _given_sigmas(
    speed_sigma: float | Sequence[float] | None, count: int
) -> tuple[float, ...] | None:
    """Stated noise of each record, rad/s, or None."""
    if speed_sigma is None:
        return None
    given = np.atleast_1d(np.asarray(speed_sigma, dtype=float)).tolist()
    for sigma in given:
        check_sigma(sigma)
    if len(given) not in (1, count):
        raise InputError(f"speed sigma: found {len(given)} values, expected 1 or {count}")
    return tuple(given * count if len(given) == 1 else given)


def _explains(outcome: Outcome, measure: Measurements, loss: Loss, noise: Sequence[float]) -> bool:
    """Whether the residuals are only noise, of the level found in the records, rad/s."""
    parts = measure.by_record(outcome.solution.residual)
    levels = residual_levels(parts, len(outcome.solution.x), loss)
    if not outcome.solution.converged or max(levels) > EXCESS:
        return False
    left = [k * sigma / n for k, sigma, n in zip(levels, measure.sigmas, noise, strict=True) if n]
    residual = outcome.solution.residual
    if len(residual) < FEW or max(left, default=0.0) < EXPLAINED:
        return True
    test = whiteness(residual, power=SHOWN)
    return min(test.runs_probability, test.ljung_box_probability) > CHANCE


def _starts(selection: Selection, prediction: SpeedPrediction) -> Iterator[Selection]:
    """The requested start, the start values from the records, and variations of them."""
    yield selection
    own = replace(selection, values=selection.fallback, told=frozenset())
    if not np.array_equal(selection.values, own.values):
        yield own
    for motor, torque in RESTARTS:
        factor = {"motor_constant": motor, "torque": torque}
        factors = [
            factor.get(dimension, 1.0) if name in selection.free else 1.0
            for name, dimension in prediction.dimensions.items()
        ]
        yield replace(own, values=own.values * factors)


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


def identify(
    records: Record | Sequence[Record],
    *,
    inertia: float | None = None,
    model: str | Law = "stribeck",
    hold: Mapping[str, float | None] | None = None,
    free: Collection[str] = (),
    prior: Mapping[str, tuple[float, float]] | None = None,
    start: Mapping[str, float] | None = None,
    speed_sigma: float | Sequence[float] | None = None,
    loss: str = "quadratic",
    current_hold: CurrentHold = "zero-order",
    max_iterations: int | None = None,
    on_progress: Progress | None = None,
    tolerance: Mapping[str, float] | None = None,
    white_noise: bool = False,
    include: Collection[str] = (),
    ripple: float | None = None,
    posterior: bool = False,
    on_draws: Callable[[int], None] = lambda count: None,
) -> Fit:
    """Identify a wheel from one or several records, fitted together.

    Carrara and Kuga, eqs. (3)-(16). By default the motor constant and the friction torques are
    estimated, with the initial speed of each record; inertia, current_bias and the Stribeck speed
    are held.

    The model is linearised at the least-squares fit. Estimates and uncertainty are then averaged
    over hypotheses on effects outside the model (`gyrostat.identification.averaging`).

    Args:
        records: Records of one wheel.
        inertia: Rotor inertia, kg·m²; held unless `free` names it.
        model: Name of the friction model, a class of your own or "FILE.py:CLASS"; or "auto": the
            simplest one, with the effects that the diagnosis finds
            (`gyrostat.identification.automatic`).
        hold: Name -> value at which it is held, SI, or None for its default.
        free: Names of further parameters to estimate.
        prior: Name -> a-priori mean and standard deviation, SI; the parameter is then estimated.
            All other parameters have a very wide a-priori distribution, which keeps the problem
            regular.
        start: Name -> start value, SI; by default the a-priori mean or a value from the records.
        speed_sigma: Standard deviation of the measured speed, rad/s, one for all records or one for
            each. By default it is estimated from the residuals of each record. All sigmas scale
            with it.
        loss: "quadratic", "huber" or "student".
        current_hold: Current between samples, "zero-order" or "linear".
        max_iterations: Largest number of iterations from one start, over all stages; by default
            `DEFAULT_ITERATIONS`.
        on_progress: Called after each iteration with the stage, the iteration count and the cost.
        tolerance: Name -> relative standard deviation of a given value: "inertia", "current_scale",
            "speed_scale", "clock" (true over recorded time).
        white_noise: Whether to assume that the friction model with white noise is exact (plain
            least squares). The resulting uncertainty is too small for real wheels.
        include: Names of further effects to average over, as the diagnosis names them.
        ripple: Torque ripple at breakaways and zero crossings, rms over the dry friction torque. By
            default it is averaged over with the other effects; few crossings hardly tell it.
        posterior: Whether to sample the posterior too (`gyrostat.identification.posterior`).
        on_draws: Called with the number of draws of the posterior so far.

    Returns:
        The fit; `converged` says whether it is valid.

    Raises:
        InputError: The arguments or the records do not allow an estimate.
    """
    records = as_records(records)
    if posterior:
        check_sampler()
        if model == AUTO or loss != "quadratic":
            raise InputError(
                "--posterior: found --model auto or --loss, expected one friction model and the "
                "quadratic loss"
            )
    if model == AUTO:
        return identify_automatically(
            identify,
            records,
            inertia=inertia,
            hold=hold or {},
            free=free,
            prior=prior or {},
            start=start or {},
            speed_sigma=speed_sigma,
            loss=loss,
            current_hold=current_hold,
            max_iterations=max_iterations,
            on_progress=on_progress,
            tolerance=tolerance,
            white_noise=white_noise,
            ripple=ripple,
        )
    pooled = [pool(cut(record)) for record in records]
    records = tuple(record for record, _ in pooled)
    chosen_loss = loss_named(loss)
    given = _given_sigmas(speed_sigma, len(records))
    if given is not None:
        given = tuple(s / np.sqrt(size) for s, (_, size) in zip(given, pooled, strict=True))
    prediction = SpeedPrediction(records, friction_law(model), current_hold)
    check_signals(records)
    deterministic = integral_regression(records)
    selection = select(
        prediction,
        deterministic,
        inertia=inertia,
        hold=hold or {},
        free=free,
        prior=prior or {},
        start=start or {},
    )
    check_start(prediction, selection)
    tolerances = check_tolerances(tolerance or {}, selection.free)
    noise = [noise_level(r.speed[r.valid]) for r in records]
    check_excitation(records, prediction.model, selection.free, noise)
    smallest = NUMERICAL_NOISE * deterministic.speed_level
    measure = Measurements(prediction, given or [max(n, smallest) for n in noise])
    most = DEFAULT_ITERATIONS if max_iterations is None else max_iterations

    best = _search(selection, measure, chosen_loss, most, noise, on_progress)
    if best is None:
        lost = [finding for r in records if (finding := lost_sign(r)) is not None]
        if lost:
            raise InputError(
                f"{place(records)}: found a {lost[0].titles[0]}, expected a signed one; "
                f"{lost[0].options[0]} restores it"
            )
        raise InputError(
            f"{place(records)}: found no start from which the modelled wheel turns as the record "
            "does, expected start or held values closer to this wheel"
        )
    if given is None:
        parts = measure.by_record(best.solution.residual)
        levels = residual_levels(parts, len(best.solution.x), chosen_loss)
        seen = zip(levels, measure.sigmas, strict=True)
        shown = Measurements(prediction, [max(level * s, smallest) for level, s in seen])
        again = refine(selection, shown, best.values, chosen_loss, most, best.solution.iterations)
        if again is not None:
            best, measure = again, shown
    fit = conclude(
        prediction,
        selection,
        best,
        chosen_loss,
        deterministic,
        speed_sigmas=measure.sigmas,
        noise=noise,
        sigma_given=given is not None,
        white_noise=white_noise,
        tolerances=tolerances,
        include=include,
        ripple=ripple,
    )
    if not (posterior and fit.converged):
        return fit
    own = [fit.names.index(name) for name in selection.free]
    found = sample_posterior(
        prediction,
        selection.free,
        fit.parameters,
        fit.covariance[np.ix_(own, own)],
        selection.prior,
        measure.sigmas,
        () if white_noise else fit.effects,
        on_progress=on_draws,
    )
    return replace(fit, posterior=found)
