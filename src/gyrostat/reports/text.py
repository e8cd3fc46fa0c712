"""Numbers and tables as text."""

import math
from collections.abc import Iterator, Sequence

from gyrostat.core.units import RPM, SI_UNIT
from gyrostat.identification import Fit


def plain(value: float, digits: int = 4) -> str:
    """A number with so many significant digits, with a power of ten where zeros would hide it."""
    return f"{value:.{digits}g}"


def measured(value: float, sigma: float) -> str:
    """A value with its standard deviation, rounded to two digits of the latter."""
    if not (math.isfinite(value) and math.isfinite(sigma)) or sigma <= 0.0:
        return plain(value)
    top = max(abs(value), sigma)
    power = math.floor(math.log10(top))
    power = 0 if -3 <= power <= 3 else 3 * (power // 3)
    decimals = max(0, 1 - math.floor(math.log10(sigma)) + power)
    scaled = f"{value / 10.0**power:.{decimals}f} ± {sigma / 10.0**power:.{decimals}f}"
    return scaled if power == 0 else f"({scaled})e{power:+03d}"


def parameter_rows(fit: Fit) -> Iterator[tuple[str, str, str, str]]:
    """Rows of the parameter table: name, value ± sigma, unit, whether it is observable.

    Args:
        fit: whose estimated and then held parameters are listed.
    """
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        seen = fit.observability[name]
        clear = "over 1000" if seen.significance > 1000.0 else f"{seen.significance:.1f}"
        verdict = f"{'yes' if seen.observable else 'NO'} ({clear} sigma)"
        verdict = "given" if seen.given else verdict
        yield name, measured(float(value), float(sigma)), SI_UNIT[fit.dimensions[name]], verdict
    for name, value in fit.held.items():
        yield name, plain(value, 6), SI_UNIT[fit.dimensions[name]], "held"


def effect_rows(fit: Fit) -> Iterator[tuple[str, str, str]]:
    """Rows of the effects beside the model: title, size given its presence, probability.

    Args:
        fit: whose effects are listed.
    """
    for effect in fit.effects:
        factor, unit = (100.0, "%") if effect.unit == "1" else (1.0, effect.unit)
        value = factor * effect.value
        size = plain(value, 2) if effect.sigma is None else measured(value, factor * effect.sigma)
        yield effect.title, f"{size} {unit}", f"{100.0 * effect.probability:.0f} %"


def score_rows(fit: Fit) -> Iterator[tuple[str, str, str]]:
    """Rows of the score tests: title, value ± sigma, significance.

    Args:
        fit: whose candidate effects are listed.
    """
    for score in fit.scores:
        factor, unit = (100.0, "%") if score.unit == "1" else (1.0, score.unit)
        size = f"{measured(factor * score.value, factor * score.sigma)} {unit}"
        yield score.title, size, f"{score.significance:.1f}"


def share_rows(fit: Fit) -> Iterator[tuple[str, ...]]:
    """Shares of the record and of each tolerance in the variance of each estimate, in per cent.

    Args:
        fit: with tolerances; without any there are no rows.
    """
    shares = fit.variance_shares
    for k, name in enumerate(fit.names):
        if shares:
            yield (name, *(f"{100.0 * float(part[k]):.0f} %" for part in shares.values()))


def summary(fit: Fit) -> list[str]:
    """What a fit says, one sentence a line."""
    records = ", ".join(r.name for r in fit.records)
    lines = [f"{fit.model.title} friction from {records} by the {fit.method} method"]
    ended = "converged" if fit.converged else "DID NOT CONVERGE"
    lines.append(
        f"{ended} after {fit.iterations} iterations; {fit.samples} samples, "
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


def aligned(rows: Sequence[Sequence[str]], header: Sequence[str]) -> list[str]:
    """A table in columns, for a terminal."""
    every = [list(header), *[list(row) for row in rows]]
    widths = [max(len(row[k]) for row in every) for k in range(len(header))]
    return [
        "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip() for row in every
    ]
