"""Result of an identification as text."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from gyrostat.core.text import aligned, measured, plain
from gyrostat.core.units import RPM, si_unit
from gyrostat.core.views import lines as text_view
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.result.temperature_trend import TemperatureTrend
from gyrostat.identification.uncertainty.averaging import Effect

if TYPE_CHECKING:
    from gyrostat.identification.uncertainty.posterior import Posterior


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


def parameter_rows(fit: Fit) -> Iterator[tuple[str, str, str, str]]:
    """Rows of the parameter table: name, value ± sigma, unit, observable or not.

    Args:
        fit: The fit; its estimated parameters come first, then the held ones.
    """
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        status = fit.observability[name]
        clear = "over 1000" if status.significance > 1000.0 else f"{status.significance:.1f}"
        verdict = f"{'yes' if status.observable else 'NO'} ({clear} sigma)"
        verdict = "given" if status.given else verdict
        # of the state at the start, the ratio would be that of its range to sigma
        verdict = "" if name.startswith(INITIAL) else verdict
        yield name, measured(float(value), float(sigma)), si_unit(fit.dimensions[name]), verdict
    for name, value in fit.held.items():
        yield name, plain(value, 6), si_unit(fit.dimensions[name]), "held"


def effect_rows(fit: Fit) -> Iterator[tuple[str, str, str]]:
    """Rows of the table of effects outside the model: title, size if present, probability.

    Args:
        fit: The fit.
    """
    yield from map(_effect_row, fit.effects)


def _effect_row(effect: Effect) -> tuple[str, str, str]:
    factor, unit = (100.0, "%") if effect.unit == "1" else (1.0, effect.unit)
    value = factor * effect.value
    size = plain(value, 2) if effect.sigma is None else measured(value, factor * effect.sigma)
    return effect.title, f"{size} {unit}", f"{100.0 * effect.probability:.0f} %"


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


def score_rows(fit: Fit) -> Iterator[tuple[str, str, str]]:
    """Rows of the score tests: title, value ± sigma, significance.

    Args:
        fit: The fit, whose candidate effects are listed.
    """
    for score in fit.scores:
        factor, unit = (100.0, "%") if score.unit == "1" else (1.0, score.unit)
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
    """Value, standard deviation and unit of a parameter, or of a difference "a-b" of two."""
    first, _, second = name.partition("-")
    contrast = np.array([float(n == first) - float(n == second) for n in fit.names])
    sigma = float(np.sqrt(contrast @ fit.covariance @ contrast))
    return float(contrast @ fit.values), sigma, si_unit(fit.dimensions[first])


def posterior_rows(fit: Fit) -> Iterator[tuple[str, str, str, str, str]]:
    """Rows of the posterior: name, median, 95 % interval, that of the Gaussian, unit.

    Args:
        fit: A fit with a posterior; without one there are no rows.
    """
    for marginal in () if fit.posterior is None else fit.posterior.marginals:
        value, sigma, unit = estimate_of(fit, marginal.name)
        half = 1.959964 * sigma
        interval = f"{plain(marginal.quantiles[0])} to {plain(marginal.quantiles[-1])}"
        gaussian = f"{plain(value - half)} to {plain(value + half)}"
        yield marginal.name, plain(marginal.quantiles[2]), interval, gaussian, unit


def share_rows(fit: Fit) -> Iterator[tuple[str, ...]]:
    """Contributions of record and tolerances to the variance of each estimate, in per cent.

    Args:
        fit: A fit with tolerances; without tolerances there are no rows.
    """
    shares = fit.variance_shares
    for k, name in enumerate(fit.names):
        if shares:
            yield (name, *(f"{100.0 * float(part[k]):.0f} %" for part in shares.values()))


def summary(fit: Fit) -> list[str]:
    """Summary of a fit, one sentence per line."""
    records = ", ".join(r.name for r in fit.records)
    lines = [f"{fit.model.title} friction from {records} by the {fit.method} method"]
    outcome = "converged" if fit.converged else "DID NOT CONVERGE"
    lines.append(
        f"{outcome} after {fit.iterations} iterations; {fit.samples} samples, "
        f"{fit.crossings} zero crossings"
    )
    if fit.rms_speed is not None:
        lines.append(
            f"residual {plain(fit.rms_speed)} rad/s rms ({plain(fit.rms_speed / RPM)} rpm), "
            f"speed noise {plain(fit.speed_sigma)} rad/s"
        )
    if fit.choices:
        lines.append(f"chosen automatically: {', '.join(fit.choices)}")
    return lines
