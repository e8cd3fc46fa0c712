"""Result of an identification as text."""

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.units import RPM, si_unit
from gyrostat.core.views import lines as text_view
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.result.inverse_dynamics import InverseDynamics
from gyrostat.identification.result.stored_fit import StoredFit
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.uncertainty.averaging import Effect

if TYPE_CHECKING:
    from gyrostat.identification.uncertainty.posterior import Posterior


Scale = Callable[[str], tuple[float, str]]
"""SI unit of a quantity -> factor and unit in which a text has it."""


def in_si(unit: str) -> tuple[float, str]:
    """Factor and unit of a text that has all quantities in SI."""
    return 1.0, unit


POSTERIOR_HEADER = ("posterior", "median", "95 % interval", "Gaussian 95 % interval", "unit")


@text_view.register
def table(fit: Fit) -> list[str]:
    """Format a fit as the command line prints it, in lines."""
    lines = summary(fit)
    header = ("parameter", "value ± sigma", "unit", "observable?")
    tables = [aligned(list(parameter_rows(fit)), header)]
    if fit.tolerances is not None:
        names = ("share of variance", *fit.variance_shares)
        tables.append(aligned(list(share_rows(fit)), names))
    likely_rows = [row for row, e in zip(effect_rows(fit), fit.effects, strict=True) if e.likely]
    if likely_rows:
        tables.append(aligned(likely_rows, ("effect outside the model", "size", "probability")))
    lines += [f"  {line}" for rows in tables for line in rows]
    for trend in fit.temperatures:
        slope = measured(trend.slope, trend.slope_sigma)
        lines.append(f"  {trend.name} changes by {slope} {trend.unit} per °C")
    if fit.inverse is not None:
        lines += fit.inverse.lines()
        lines += [f"  {line}" for line in aligned([*fit.inverse.rows()], fit.inverse.header())]
    if fit.posterior is not None:
        lines += posterior_summary(fit.posterior)
        lines += [f"  {line}" for line in aligned(list(posterior_rows(fit)), POSTERIOR_HEADER)]
    lines += [f"warning: {warning}" for warning in fit.warnings]
    if fit.impossible:
        lines += [
            "no valid result; model.toml is marked and accepted only with --force: "
            + "; ".join(fit.impossible),
        ]
    return lines


INITIAL = "initial_speed"
"""Begin of the names of the states at the start of each record."""


def parameter_rows(fit: Fit, scale: Scale = in_si) -> Iterator[tuple[str, str, str, str]]:
    """Rows of the parameter table: name, value ± sigma, unit, observable or not.

    Args:
        fit: The fit; its estimated parameters come first, then the held ones.
        scale: Shown units.
    """
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        status = fit.observability[name]
        clear = "over 1000" if status.significance > 1000.0 else f"{status.significance:.1f}"
        verdict = f"{'yes' if status.observable else 'NO'} ({clear} sigma)"
        verdict = "given" if status.given else verdict
        # of the state at the start, the ratio would be that of its range to sigma
        verdict = "" if name.startswith(INITIAL) else verdict
        factor, unit = scale(si_unit(fit.dimensions[name]))
        yield name, measured(factor * float(value), factor * float(sigma)), unit, verdict
    for name, value in fit.held.items():
        factor, unit = scale(si_unit(fit.dimensions[name]))
        yield name, plain(factor * value, 6), unit, "held"


def effect_rows(fit: Fit, scale: Scale = in_si) -> Iterator[tuple[str, str, str]]:
    """Rows of the table of effects outside the model: title, size if present, probability.

    Args:
        fit: The fit.
        scale: Shown units.
    """
    for effect in fit.effects:
        yield _effect_row(effect, scale)


def _effect_row(effect: Effect, scale: Scale = in_si) -> tuple[str, str, str]:
    factor, unit = (100.0, "%") if effect.unit == "1" else scale(effect.unit)
    value = factor * effect.value
    size = plain(value, 2) if effect.sigma is None else measured(value, factor * effect.sigma)
    return effect.title, f"{size} {unit}", f"{100.0 * effect.probability:.0f} %"


@text_view.register
def stored_table(fit: StoredFit) -> list[str]:
    """Format the parameters of a file of a fit with its wheel and date, in lines."""
    about = [fit.model, *filter(None, (fit.serial, fit.date and str(fit.date)))]
    warm = [] if fit.temperature is None else [f"{plain(fit.temperature)} °C"]
    sigma = np.sqrt(np.diag(fit.covariance))
    rows = [
        (name, measured(float(value), float(error)), unit)
        for name, value, error, unit in zip(fit.names, fit.values, sigma, fit.units, strict=True)
    ]
    table = aligned(rows, ("parameter", "value ± sigma", "unit"))
    return [f"{fit.name}: {', '.join([*about, *warm])}", *table]


@text_view.register
def inverse_table(result: InverseDynamics) -> list[str]:
    """Format the estimators of the inverse dynamics, in lines."""
    return [*result.lines(), *aligned([*result.rows()], result.header())]


@text_view.register
def effect_table(effect: Effect) -> list[str]:
    """Format an effect outside the model with its header, in lines."""
    return aligned([_effect_row(effect)], ("effect", "size if present ± sigma", "probability"))


@text_view.register
def temperature_table(trend: TemperatureTrend) -> list[str]:
    """Format the values of a parameter over temperature, and their slope, in lines."""
    rows = [
        (f"{plain(temperature)} °C", measured(value, sigma), trend.unit)
        for temperature, value, sigma in zip(
            trend.temperature, trend.value, trend.sigma, strict=True
        )
    ]
    slope = ("slope", measured(trend.slope, trend.slope_sigma), f"{trend.unit}/°C")
    return aligned([*rows, slope], (trend.name, "value ± sigma", "unit"))


def score_rows(fit: Fit, scale: Scale = in_si) -> Iterator[tuple[str, str, str]]:
    """Rows of the score tests: title, value ± sigma, significance.

    Args:
        fit: The fit, whose candidate effects are listed.
        scale: Shown units.
    """
    for score in fit.scores:
        factor, unit = (100.0, "%") if score.unit == "1" else scale(score.unit)
        size = f"{measured(factor * score.value, factor * score.sigma)} {unit}"
        yield score.title, size, f"{score.significance:.1f}"


def posterior_summary(posterior: "Posterior") -> list[str]:
    """Draws of a posterior, and whether it is valid, one sentence per line."""
    draws = len(posterior.marginals[0].draws)
    lines = [f"posterior: {draws} draws in {posterior.chains} chains"]
    if not posterior.valid:
        lines.append(f"no valid posterior: {'; '.join(posterior.faults)}")
    return lines


def estimate_of(fit: Fit, name: str) -> tuple[float, float, str]:
    """Value, standard deviation and SI unit of a parameter, or of a difference "a-b" of two."""
    first, _, second = name.partition("-")
    contrast = np.array([float(n == first) - float(n == second) for n in fit.names])
    sigma = float(np.sqrt(contrast @ fit.covariance @ contrast))
    return float(contrast @ fit.values), sigma, si_unit(fit.dimensions[first])


def posterior_rows(fit: Fit, scale: Scale = in_si) -> Iterator[tuple[str, str, str, str, str]]:
    """Rows of the posterior: name, median, 95 % interval, that of the Gaussian, unit.

    Args:
        fit: A fit with a posterior; without one there are no rows.
        scale: Shown units.
    """
    for marginal in () if fit.posterior is None else fit.posterior.marginals:
        value, sigma, unit = estimate_of(fit, marginal.name)
        factor, unit = scale(unit)
        low, middle, high = (plain(factor * marginal.quantiles[k]) for k in (0, 2, -1))
        ends = [plain(factor * (value + side * 1.959964 * sigma)) for side in (-1.0, 1.0)]
        yield marginal.name, middle, f"{low} to {high}", " to ".join(ends), unit


def share_rows(fit: Fit) -> Iterator[tuple[str, ...]]:
    """Contributions of record and tolerances to the variance of each estimate, in per cent.

    Args:
        fit: A fit with tolerances; without tolerances there are no rows.
    """
    shares = fit.variance_shares
    for k, name in enumerate(fit.names):
        if shares:
            yield (name, *(f"{100.0 * float(part[k]):.0f} %" for part in shares.values()))


def summary(fit: Fit, scale: Scale = in_si) -> list[str]:
    """Summary of a fit in shown units, one sentence per line."""
    records = ", ".join(r.name for r in fit.records)
    lines = [f"{fit.model.title} friction from {records} by the {fit.method} method"]
    outcome = "converged" if fit.converged else "DID NOT CONVERGE"
    lines.append(
        f"{outcome} after {fit.iterations} iterations; {fit.samples} samples, "
        f"{fit.crossings} zero crossings"
    )
    if fit.rms_speed is not None:
        factor, unit = scale("rad/s")
        revolutions = "" if unit == "rpm" else f" ({plain(fit.rms_speed / RPM)} rpm)"
        lines.append(
            f"residual {plain(factor * fit.rms_speed)} {unit} rms{revolutions}, "
            f"speed noise {plain(factor * fit.speed_sigma)} {unit}"
        )
    if fit.choices:
        lines.append(f"chosen automatically: {', '.join(fit.choices)}")
    return lines
