"""One model of a wheel from the fits of its records at several dates and temperatures."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.judge.fit_changes import DAY, days, in_order_of_date
from gyrostat.identification.judge.fit_comparison import BENCH
from gyrostat.identification.judge.spread import holm, two_sided
from gyrostat.identification.pool.held_out import FEWEST, held_out_scores, log_scores
from gyrostat.identification.pool.joint import predicted_correlation
from gyrostat.identification.pool.mixture import Mixture
from gyrostat.identification.pool.oil import Oil
from gyrostat.identification.pool.one_wheel import require_one_wheel
from gyrostat.identification.pool.pool_notes import notes
from gyrostat.identification.pool.posterior import Estimates, Posterior, posterior
from gyrostat.identification.pool.result import (
    INTERVAL,
    Conditions,
    HeldOut,
    Pool,
    PooledParameter,
    Quantity,
)
from gyrostat.identification.pool.usual import is_viscous, laws_over_temperature, usual
from gyrostat.identification.result.stored_fit import StoredFit

YEAR = 365.25
"""Days of a year."""
FRICTION = ("viscous", "coulomb", "static")
"""Parameters that are positive in every wheel."""
KNOWN = 0.5
"""Share of its prior sigma below which that of a slope counts as determined by the records."""


def pool_fits(
    fits: Sequence[StoredFit],
    labels: Sequence[str],
    *,
    temperature: float | None = None,
    date: datetime | None = None,
    oil: Oil | None = None,
    same_bench: bool = False,
) -> Pool:
    """Pool the fits of the records of one wheel.

    Args:
        fits: At least two fits, each of one record or of records under the same conditions.
        labels: Label of each fit.
        temperature: Temperature of the prediction, °C; by default the mean of the records.
        date: Date of the prediction; by default that of the last record.
        oil: Oil of the bearings; None if it is unknown.
        same_bench: Whether all records are from one bench, with one error of each scale.

    Raises:
        InputError: There are too few fits, they do not belong together, or the prediction needs
            temperatures or dates that the records lack.
    """
    require_one_wheel(fits)
    fits, labels = in_order_of_date(fits, labels)
    conditions = _conditions(fits, temperature, date)
    values = np.array([fit.values for fit in fits])
    roots = _shared_roots(fits, same_bench=same_bench)
    shared = np.mean(roots / values[:, :, None], axis=0)
    covariances = np.array([fit.covariance for fit in fits])
    covariances = covariances - np.einsum("kim,kjm->kij", roots, roots)
    # a rounded fit.json may leave no variance of its own beside that of a tolerance
    own = np.maximum(np.einsum("kii->ki", covariances), 1e-6 * np.sum(roots**2, axis=2))
    np.einsum("kii->ki", covariances)[:] = own
    parameters = {
        name: _parameter(
            (name, fits[0].units[k]), values[:, k], np.sqrt(own[:, k]), shared[k], conditions, oil
        )
        for k, name in enumerate(fits[0].names)
    }
    sizes = np.array([p.size for p in parameters.values()])
    predicted = np.array([p.prediction.value for p in parameters.values()]) / sizes
    correlation = predicted_correlation(
        [p.posterior for p in parameters.values()],
        covariances / np.outer(sizes, sizes),
        shared * predicted[:, None],
        conditions.temperature,
        conditions.year - conditions.middle,
    )
    _require_friction(parameters, conditions)
    parameters = _with_adjusted_chances(parameters)
    return Pool(
        fits=tuple(fits),
        labels=tuple(labels),
        conditions=conditions,
        parameters=parameters,
        correlation=correlation,
        notes=notes(fits, labels, conditions, parameters),
    )


def _require_friction(parameters: Mapping[str, PooledParameter], conditions: Conditions) -> None:
    """Require positive friction of a prediction outside the conditions of the records.

    Raises:
        InputError: A trend or a law over temperature leads below 0.
    """
    outside = " and ".join(f"--{name}" for name, is_so in conditions.is_outside.items() if is_so)
    for name, parameter in parameters.items() if outside else ():
        value = parameter.prediction.value
        if name in FRICTION and value <= 0.0:
            raise InputError(
                f"{outside}: found a prediction of {name} of {value:.3g} {parameter.unit}, outside "
                "the records, expected a positive one: a condition nearer to them"
            )


def _parameter(
    kind: tuple[str, str],
    values: Vector,
    errors: Vector,
    shared: Vector,
    conditions: Conditions,
    oil: Oil | None,
) -> PooledParameter:
    """Pool one parameter with a name and a unit."""
    (name, unit), count = kind, len(values)
    reference, years = conditions.reference, conditions.years
    usually = usual(name)
    estimates, size = relative_estimates(kind, values, errors, conditions, oil)
    result = posterior(estimates)
    place = conditions.temperature, conditions.year - conditions.middle
    prediction = result.prediction(*place)
    common = float(np.sqrt(np.sum(shared**2))) * abs(prediction.mean)
    typical = float(np.exp(np.mean(np.log(estimates.errors))))
    slope = None if reference is None else result.slope(*place)
    usual_slope = float(np.mean([law.slope_sigma for law in estimates.laws]))
    trend = None if years is None else result.trend(place[0])
    return PooledParameter(
        name=name,
        unit=unit,
        size=size,
        values=values,
        errors=errors,
        shared=float(np.sqrt(np.sum(shared**2))),
        posterior=result,
        mean=Quantity.of(_widened(result.mean(*place), common), size),
        scatter=_scatter(result, size, place),
        trend=None if trend is None else Quantity.of(trend, size),
        trend_known=trend is not None and result.coefficient(1).sigma < KNOWN * usually.trend,
        slope=None if slope is None else Quantity.of(slope, size),
        slope_known=reference is not None
        and result.slope(reference, 0.0).sigma < KNOWN * usual_slope,
        prediction=Quantity.of(_widened(prediction, common), size),
        record=Quantity.of(result.prediction(*place, error=typical), size),
        pooled=tuple(
            Quantity.of(_widened(result.of_record(k), common), size) for k in range(count)
        ),
        held_out=_held_out(estimates, reference, compares_laws=is_viscous(unit)),
    )


def relative_estimates(
    kind: tuple[str, str], values: Vector, errors: Vector, conditions: Conditions, oil: Oil | None
) -> tuple[Estimates, float]:
    """Estimates of one parameter with what is known of wheels in general.

    Args:
        kind: Name and unit of the parameter.
        values: Estimates, (n,), SI.
        errors: Standard deviations of their errors, (n,), SI.
        conditions: Temperatures and dates.
        oil: Oil; None if it is unknown.

    Returns:
        Estimates relative to the size of the parameter, and this size, SI.
    """
    name, unit = kind
    size = max(float(np.median(np.abs(values))), float(np.sqrt(np.mean(errors**2))))
    warm, years = conditions.temperatures, conditions.years
    estimates = Estimates(
        values=values / size,
        errors=errors / size,
        temperature=np.zeros(len(values)) if warm is None else warm,
        date=np.zeros(len(values)) if years is None else years - conditions.middle,
        laws=laws_over_temperature(name, unit, conditions.reference, oil),
        trend=None if years is None else usual(name).trend,
        usual=usual(name).scatter,
    )
    return estimates, size


def _scatter(result: Posterior, size: float, place: tuple[float, float]) -> Quantity:
    """Standard deviation between records at a temperature, SI."""
    factor = size * result.factor(place[0])
    middle, low, high, below, above = (
        factor * result.scatter_quantile(share) for share in (0.5, *INTERVAL, 0.1587, 0.8413)
    )
    return Quantity(middle, 0.5 * (above - below), low, high)


def _held_out(estimates: Estimates, reference: float | None, *, compares_laws: bool) -> HeldOut:
    """Prediction of each record from all others; nothing if there are too few."""
    if len(estimates.values) < FEWEST:
        return HeldOut(np.zeros(0), np.zeros(0), {})
    scores, density = held_out_scores(estimates)
    densities = {}
    if compares_laws and reference is not None:
        densities = {"oil": density, **log_scores(estimates, reference)}
    return HeldOut(scores, np.array([two_sided(z) for z in scores]), densities)


def _widened(mixture: Mixture, error: float) -> Mixture:
    """Mixture with a further, independent error."""
    return replace(mixture, sigmas=np.hypot(mixture.sigmas, error))


def _with_adjusted_chances(
    parameters: Mapping[str, PooledParameter],
) -> dict[str, PooledParameter]:
    """Parameters with p-values for all held-out records together (Holm)."""
    count = len(next(iter(parameters.values())).held_out.scores)
    chances = holm(np.concatenate([p.held_out.chances for p in parameters.values()]).tolist())
    return {
        p.name: replace(
            p, held_out=replace(p.held_out, chances=chances[k * count : (k + 1) * count])
        )
        for k, p in enumerate(parameters.values())
    }


def _conditions(
    fits: Sequence[StoredFit], temperature: float | None, date: datetime | None
) -> Conditions:
    """Temperatures and dates of records and prediction."""
    times = days(fits)
    # dates that are equal show no trend
    years = None if times is None or np.ptp(times) == 0.0 else times / YEAR
    warm = [fit.temperature for fit in fits if fit.temperature is not None]
    temperatures = np.array(warm) if len(warm) == len(fits) else None
    lacking = [
        (name, fit.name)
        for name, value, wanted in (
            ("temperature", lambda fit: fit.temperature, temperature),
            ("date", lambda fit: fit.date, date),
        )
        if wanted is not None
        for fit in fits
        if value(fit) is None
    ]
    for name, file in lacking:
        raise InputError(
            f"--{name}: found one, but {file} has none, expected the {name} of each record "
            f"(--{name}s)"
        )
    year = 0.0 if years is None else float(years.max())
    if date is not None:
        first = min(fit.date for fit in fits if fit.date is not None)
        if years is None:
            raise InputError("--date: found one, but all records have the same date")
        year = (date - first).total_seconds() / DAY / YEAR
    if temperature is None:
        temperature = 0.0 if temperatures is None else float(np.mean(temperatures))
    return Conditions(temperatures, years, temperature, year)


def _shared_roots(fits: Sequence[StoredFit], *, same_bench: bool) -> Matrix:
    """Errors that all records share, one sigma of each tolerance, (n, p, tolerances), SI."""
    columns = [np.zeros((len(fits), len(fits[0].names), 0))]
    for name in ("inertia", *(BENCH if same_bench else ())):
        sigmas = {fit.tolerances[name].sigma if name in fit.tolerances else None for fit in fits}
        if len(sigmas) == 1 and None not in sigmas:
            columns.append(np.array([fit.tolerances[name].errors for fit in fits])[:, :, None])
    return np.concatenate(columns, axis=2)
