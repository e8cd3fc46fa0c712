"""Pooled records as text."""

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.views import lines as text_view
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.pool.laws import KnownOil
from gyrostat.identification.pool.result import INTERVAL, Pool, PooledParameter, Quantity

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]
"""Title, header and rows."""


def conditions_text(pool: Pool) -> str:
    """Temperature and date of the prediction."""
    conditions = pool.conditions
    parts = []
    if conditions.temperatures is not None:
        parts.append(f"at {conditions.temperature:.3g} °C")
    if conditions.years is not None:
        parts.append(f"{conditions.year:.2g} years after the first record")
    return ", ".join(parts) or "under the conditions of the records"


def _interval(quantity: Quantity, digits: int = 4) -> str:
    return f"{plain(quantity.low, digits)} to {plain(quantity.high, digits)}"


def _prediction(parameter: PooledParameter) -> tuple[str, ...]:
    prediction, record = parameter.prediction, parameter.record
    return (
        parameter.name,
        measured(prediction.value, prediction.sigma),
        _interval(prediction),
        measured(parameter.mean.value, parameter.mean.sigma),
        _interval(record),
        parameter.unit,
    )


def _variation(parameter: PooledParameter) -> tuple[str, ...]:
    scatter, slope, trend = parameter.scatter, parameter.slope, parameter.trend
    share = 100.0 * scatter.value / abs(parameter.mean.value)
    return (
        parameter.name,
        f"{plain(scatter.value, 3)} ({plain(scatter.low, 2)} to {plain(scatter.high, 2)})",
        f"{share:.2g} %",
        plain(float((parameter.errors**2).mean() ** 0.5), 3),
        _change(slope, parameter.slope_known),
        _change(trend, parameter.trend_known),
        parameter.unit,
    )


def _change(change: Quantity | None, is_known: bool) -> str:
    if change is None:
        return "unknown"
    text = measured(change.value, change.sigma)
    return text if is_known else f"{text}, not determined"


def tables(pool: Pool) -> list[Table]:
    """Title, header and rows of the tables on all records."""
    every = tuple(pool.parameters.values())
    predicted = ("parameter", "value ± sigma", "95 % interval", "mean over records")
    varying = ("parameter", "sigma between records (95 %)", "share", "error of one record")
    return [
        (
            f"Wheel in a further record, {conditions_text(pool)}",
            (*predicted, "estimate of a record, 95 %", "unit"),
            [_prediction(p) for p in every],
        ),
        (
            "What varies",
            (*varying, "change per °C", "change per year", "unit"),
            [_variation(p) for p in every],
        ),
        (
            "Each record against its prediction from the others, in standard deviations",
            ("record", "°C", *pool.parameters),
            [
                (pool.labels[k], _temperature(pool, k), *(_score(p, k) for p in every))
                for k in range(len(pool.fits))
                if all(len(p.held_out.scores) for p in every)
            ],
        ),
    ]


def record_tables(pool: Pool) -> list[Table]:
    """Title, header and rows of a table of the records for each parameter."""
    return [
        (
            f"{parameter.name} ({parameter.unit})",
            ("record", "°C", "alone", "with the others"),
            [_record(pool, parameter, k) for k in range(len(pool.fits))],
        )
        for parameter in pool.parameters.values()
    ]


def _score(parameter: PooledParameter, k: int) -> str:
    mark = " *" if parameter.held_out.chances[k] <= FALSE_ALARMS else ""
    return f"{parameter.held_out.scores[k]:+.2f}{mark}"


def _temperature(pool: Pool, k: int) -> str:
    warm = pool.fits[k].temperature
    return "" if warm is None else f"{warm:.1f}"


def _record(pool: Pool, parameter: PooledParameter, k: int) -> tuple[str, ...]:
    pooled = parameter.pooled[k]
    return (
        pool.labels[k],
        _temperature(pool, k),
        measured(float(parameter.values[k]), float(parameter.errors[k])),
        measured(pooled.value, pooled.sigma),
    )


def laws_text(pool: Pool) -> list[str]:
    """Laws over temperature of viscous friction, and their comparison with polynomials."""
    lines = []
    for parameter in pool.parameters.values():
        if isinstance(parameter.posterior.estimates.laws[0], KnownOil):
            power, low, high = (parameter.posterior.shape_quantile(p) for p in (0.5, *INTERVAL))
            lines.append(
                f"{parameter.name} is proportional to the viscosity of the oil to the power "
                f"{power:.2f} ({low:.2f} to {high:.2f})"
            )
        densities = parameter.held_out.log_scores
        if densities:
            gains = ", ".join(
                f"{name} {value - densities['oil']:+.1f}"
                for name, value in densities.items()
                if name != "oil"
            )
            lines.append(
                f"{parameter.name} by the viscosity of an oil: log score of held-out records "
                f"{densities['oil']:.1f}; polynomials against it: {gains}"
            )
    return lines


@text_view.register
def pool_table(pool: Pool) -> list[str]:
    """Format pooled records as the command line prints them, in lines."""
    lines = [f"{len(pool.fits)} records of one wheel, {pool.fits[0].model} friction"]
    for title, header, rows in tables(pool):
        if rows:
            lines += [title, *(f"  {line}" for line in aligned(rows, header))]
    lines += laws_text(pool)
    return [*lines, *(f"note: {note}" for note in pool.notes)]
