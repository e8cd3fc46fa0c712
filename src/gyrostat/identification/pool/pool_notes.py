"""Remarks on pooled records whose results are less certain."""

from collections.abc import Mapping, Sequence

from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.pool.laws import POWERS, KnownOil
from gyrostat.identification.pool.pool_model import below_limits
from gyrostat.identification.pool.result import Conditions, PooledParameter
from gyrostat.identification.result.stored_fit import StoredFit
from gyrostat.wheel.friction import FRICTION_MODELS

FEW = 5
"""Number of records below which the scatter is hardly known."""
AT_END = 0.05
"""Distance from an end of the range of powers, share of the range, that is reported."""
BETTER = 2.0
"""Difference of log scores, over all records, that is reported."""


def notes(
    fits: Sequence[StoredFit],
    labels: Sequence[str],
    conditions: Conditions,
    parameters: Mapping[str, PooledParameter],
) -> tuple[str, ...]:
    """Remarks on pooled records.

    Args:
        fits: Fits of the records.
        labels: Label of each record.
        conditions: Temperatures and dates.
        parameters: Name -> parameter over the records.
    """
    remarks = []
    if len(fits) < FEW:
        remarks.append(
            f"{len(fits)} records hardly show the scatter between records: the intervals are wide, "
            "and rest on what is usual for wheels"
        )
    remarks += _on_temperatures(fits, conditions, parameters)
    remarks += _on_dates(fits, conditions, parameters)
    for name, parameter in parameters.items():
        remarks += [
            f"{labels[k]} does not agree with the prediction from the other records: {name} is "
            f"{score:+.1f} sigma away (p = {chance:.2g}); the result includes it"
            for k, (score, chance) in enumerate(
                zip(parameter.held_out.scores, parameter.held_out.chances, strict=True)
            )
            if chance <= FALSE_ALARMS
        ]
        remarks += _on_laws(parameter)
    return tuple(remarks + _on_limits(fits[0].model, parameters))


def _on_limits(model: str, parameters: Mapping[str, PooledParameter]) -> list[str]:
    if model not in FRICTION_MODELS:
        return []
    values = {name: p.prediction.value for name, p in parameters.items()}
    return [
        f"the prediction of {name}, {values[name]:.3g}, is below that of {limit}, "
        f"{values[limit]:.3g} N·m, and within 2 sigma of it: model.toml has the latter for both"
        for name, limit in below_limits(FRICTION_MODELS[model], parameters, values)
    ]


def _on_temperatures(
    fits: Sequence[StoredFit], conditions: Conditions, parameters: Mapping[str, PooledParameter]
) -> list[str]:
    warm = conditions.temperatures
    if warm is None:
        name = next(fit.name for fit in fits if fit.temperature is None)
        return [
            f"no law over temperature: {name} has no temperature (a column of the record, or "
            "--temperatures); its effect is part of the scatter"
        ]
    remarks = []
    unknown = [p.name for p in parameters.values() if not p.slope_known]
    if unknown:
        remarks.append(
            f"records from {warm.min():.3g} to {warm.max():.3g} °C do not determine the law over "
            f"temperature of {', '.join(unknown)}: at other temperatures, the prediction is as "
            "wide as is usual for wheels"
        )
    if conditions.is_outside["temperature"]:
        remarks.append(
            f"{conditions.temperature:.3g} °C is outside the temperatures of the records, "
            f"{warm.min():.3g} to {warm.max():.3g} °C: the prediction rests on the form of the law"
        )
    return remarks


def _on_dates(
    fits: Sequence[StoredFit], conditions: Conditions, parameters: Mapping[str, PooledParameter]
) -> list[str]:
    years = conditions.years
    if years is None:
        without = [fit for fit in fits if fit.date is None]
        why = "all records have one date"
        if without:
            unread = without[0].unread_date
            what = f"the date {unread!r}, which is not one that is read" if unread else "no date"
            why = f"{without[0].name} has {what}"
        return [
            f"no trend over the date: {why} (comment '# date: 2026-03-01' in each record, or "
            "--dates)"
        ]
    remarks = []
    if conditions.is_outside["date"]:
        away = max(years.min() - conditions.year, conditions.year - years.max())
        remarks.append(
            f"the date of the prediction is {away:.2g} years outside those of the records: the "
            "prediction rests on a trend that is a straight line"
        )
    unknown = [p.name for p in parameters.values() if not p.trend_known]
    if unknown:
        remarks.append(
            f"records over {float(years.max()):.2g} years do not determine the trend of "
            f"{', '.join(unknown)}: at later dates, the prediction is as wide as is usual for "
            "wheels"
        )
    return remarks


def _on_laws(parameter: PooledParameter) -> list[str]:
    remarks = _on_power(parameter)
    densities = parameter.held_out.log_scores
    if not densities:
        return remarks
    best = max(densities, key=lambda name: densities[name])
    gain = densities[best] - densities["oil"]
    if gain < BETTER:
        return remarks
    return [
        *remarks,
        f"{parameter.name}: a {best} in temperature predicts the held-out records better than the "
        f"oil's viscosity does (log score higher by {gain:.1f}): an --oil that is wrong, or "
        "friction that is not that of an oil",
    ]


def _on_power(parameter: PooledParameter) -> list[str]:
    """Remark on a power of the viscosity at an end of its range."""
    posterior = parameter.posterior
    if not isinstance(posterior.estimates.laws[0], KnownOil):
        return []
    power = posterior.shape_quantile(0.5)
    if min(power - POWERS[0], POWERS[1] - power) > AT_END * (POWERS[1] - POWERS[0]):
        return []
    return [
        f"{parameter.name}: the power of the viscosity, {power:.2f}, is at the end of its range, "
        f"{POWERS[0]:g} to {POWERS[1]:g}: another oil, or friction that is not that of an oil"
    ]
