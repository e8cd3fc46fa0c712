"""Analysis of a lot as text."""

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.views import lines as text_view
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.lot.result import Interval, Lot, LotParameter

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]
"""Title, header and rows."""


def _interval(item: Interval) -> str:
    return f"{plain(item.value, 3)} ({plain(item.low, 2)} to {plain(item.high, 2)})"


def _spread(parameter: LotParameter) -> tuple[str, ...]:
    return (
        parameter.name,
        plain(parameter.median.value),
        _interval(parameter.sigma),
        plain(parameter.sigma_estimates, 3),
        plain(parameter.sigma_errors, 3),
        _interval(parameter.shape),
        parameter.unit,
    )


def _limits(parameter: LotParameter, factors: tuple[float, float]) -> tuple[str, ...]:
    limits, (one, two) = parameter.limits, factors
    mean, sigma = float(parameter.values.mean()), parameter.sigma_estimates
    ends = mean - one * sigma, mean + one * sigma, mean - two * sigma, mean + two * sigma
    hierarchical = (limits.lower, limits.upper, limits.low, limits.high)
    cells = [plain(value) for value in (*hierarchical, *ends)]
    low, high = f"{cells[2]} to {cells[3]}", f"{cells[6]} to {cells[7]}"
    return (parameter.name, *cells[:2], low, *cells[4:6], high, parameter.unit)


def _chart(lot: Lot, parameter: LotParameter) -> tuple[str, ...]:
    trend, chart = parameter.drift, parameter.chart
    slope = "" if trend is None else f"{measured(trend.slope, trend.sigma)} {parameter.unit}"
    chance = "" if trend is None else ("< 0.0001" if trend.chance < 1e-4 else f"{trend.chance:.4f}")
    beyond, shifts = (
        ", ".join(lot.labels[k] for k in wheels) for wheels in (chart.beyond, chart.shifts)
    )
    return parameter.name, slope, chance, beyond or "none", shifts or "none"


def tables(lot: Lot) -> list[Table]:
    """Title, header and rows of each table."""
    every = tuple(lot.parameters.values())
    content, confidence = 100.0 * lot.content, 100.0 * lot.confidence
    one, two = lot.factors
    spread = ("parameter", "median", "sigma of wheels (95 %)", "of estimates", "of errors")
    limits = ("parameter", "lower", "upper", "interval")
    names = tuple(lot.parameters)
    pairs = [(i, j) for i in range(len(names)) for j in range(i)]
    matrix = lot.correlation
    correlations = [
        (
            f"{names[j]}, {names[i]}",
            _interval(Interval(matrix.value[i, j], matrix.low[i, j], matrix.high[i, j]))
            if matrix.value[i, j] == matrix.value[i, j]
            else "not determined",
            plain(matrix.estimates[i, j], 2),
        )
        for i, j in pairs
    ]
    drift = ("parameter", "change per year ± sigma", "p", "beyond 3 sigma", "CUSUM signals at")
    return [
        ("Spread", (*spread, "shape (95 %)", "unit"), [_spread(p) for p in every]),
        (
            f"Limits for {content:.4g} % of the wheels with {confidence:.4g} % confidence, and "
            f"classical ones (k = {one:.4g}, {two:.4g}) that count errors as spread",
            (*limits, "classical lower", "upper", "interval", "unit"),
            [_limits(p, lot.factors) for p in every],
        ),
        ("Correlation", ("parameters", "of wheels (95 %)", "of estimates"), correlations),
        ("Over the dates of production", drift, [_chart(lot, p) for p in every]),
    ]


def outliers_text(lot: Lot) -> str:
    """Outliers in one sentence."""
    wheels = [f"{label} ({name}, p = {chance:.2g})" for label, name, chance in lot.outliers]
    text = ", ".join(wheels) or "none"
    return f"outliers ({100.0 * FALSE_ALARMS:.0f} % false alarms over the lot): {text}"


def best_text(lot: Lot) -> str:
    """Best set in one sentence."""
    best = lot.best
    wheels = ", ".join(
        f"{lot.labels[k]} ({100.0 * share:.0f} %)"
        for k, share in zip(best.wheels, best.each, strict=True)
    )
    unit = lot.parameters[best.parameter].unit
    meaning = {
        "lowest": "the lowest mean",
        "highest": "the highest mean",
        "matched": "the smallest standard deviation",
    }[best.rule]
    return (
        f"best set of {len(best.wheels)}, with {meaning} of {best.parameter}: {wheels}; it is the "
        f"best with a probability of {plain(100.0 * best.probability, 3)} %, and "
        f"{plain(best.excess, 2)} {unit} from the best on average"
    )


@text_view.register
def lot_table(lot: Lot) -> list[str]:
    """Format a lot as the command line prints it, in lines."""
    lines = [f"lot of {len(lot.fits)} wheels, {lot.fits[0].model} friction, shape {lot.shape}"]
    for title, header, rows in tables(lot):
        if rows:
            lines += [title, *(f"  {line}" for line in aligned(rows, header))]
    lines += [outliers_text(lot), best_text(lot)]
    return [*lines, *(f"note: {note}" for note in lot.notes)]
