"""Analysis of a lot of wheels, each with one fit."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.skewed_normal import deviation
from gyrostat.core.types import Vector
from gyrostat.identification.judge.fit_changes import days, in_order_of_date
from gyrostat.identification.judge.fit_comparison import BENCH
from gyrostat.identification.judge.spread import holm
from gyrostat.identification.lot.best_set import SEED, best_set, true_values
from gyrostat.identification.lot.correlation import correlation
from gyrostat.identification.lot.limits import (
    one_sided_factor,
    tolerance_limits,
    two_sided_factor,
)
from gyrostat.identification.lot.lot_notes import notes
from gyrostat.identification.lot.outliers import outliers, scores
from gyrostat.identification.lot.over_dates import control_chart, drift
from gyrostat.identification.lot.posterior import LotDraws, lot_draws
from gyrostat.identification.lot.result import Lot, LotParameter, interval
from gyrostat.identification.result.stored_fit import StoredFit

FEWEST = 20
"""Smallest number of wheels for which the confidence of the limits was measured."""
SURE = 5.0
"""Number of standard deviations from zero at which the sign of an estimate is that of the wheel."""


def analyse_lot(
    fits: Sequence[StoredFit],
    labels: Sequence[str],
    *,
    shape: str,
    content: float,
    confidence: float,
    best: tuple[str, str],
    set_size: int,
    same_bench: bool,
) -> Lot:
    """Analyse a lot of wheels.

    Args:
        fits: Fits of different wheels, of one friction model.
        labels: Label of each wheel.
        shape: "unknown", "normal" or "log-normal"; see `gyrostat.identification.lot.posterior`.
        content: Share of the wheels that tolerance limits contain.
        confidence: Probability that they do.
        best: Rule and parameter of the best set; an empty parameter stands for the Coulomb torque
            or, without one, for the first parameter.
        set_size: Number of wheels of the best set.
        same_bench: Whether all records are from one bench, with one error of each scale.

    Raises:
        InputError: There are too few wheels, or they do not belong together.
    """
    _check(fits, labels, shape, best[1])
    fits, labels = in_order_of_date(fits, labels)
    times = days(fits)
    common = _common_errors(fits) if same_bench else np.zeros(len(fits[0].names))
    values = np.array([fit.values for fit in fits])
    covariances = np.array([fit.covariance for fit in fits]) - np.outer(common, common)
    parameters = {}
    for k, name in enumerate(fits[0].names):
        errors = np.sqrt(np.maximum(covariances[:, k, k], 1e-6 * common[k] ** 2))
        parameters[name] = _parameter(
            fits[0], k, values[:, k], errors, float(common[k]), shape, (content, confidence), times
        )
    parameters = _with_adjusted_drifts(parameters)
    rule, parameter = best[0], best[1] or _default(fits[0].names)
    judged = parameters[parameter]
    random = np.random.default_rng(SEED)
    draws = true_values(judged.values, judged.errors, judged.draws.typical(), random)
    return Lot(
        fits=tuple(fits),
        labels=tuple(labels),
        days=times,
        parameters=parameters,
        correlation=correlation(values, covariances),
        best=best_set(rule, parameter, draws, set_size),
        shape=shape,
        content=content,
        confidence=confidence,
        factors=(
            one_sided_factor(len(fits), content, confidence),
            two_sided_factor(len(fits), content, confidence),
        ),
        notes=notes(fits, parameters, shape),
    )


def _parameter(
    fit: StoredFit,
    place: int,
    values: Vector,
    errors: Vector,
    common: float,
    shape: str,
    share: tuple[float, float],
    times: Vector | None,
) -> LotParameter:
    """Distribution of one parameter over the lot."""
    draws = lot_draws(values, errors, shape)
    # that of the typical lot, as in lot.toml: the median over the draws is larger in small lots
    value = float(deviation(*draws.typical()[1:]))
    spread = replace(interval(draws, deviation(draws.scale, draws.shape)), value=value)
    shifted = _with_common_error(draws, common)
    return LotParameter(
        name=fit.names[place],
        unit=fit.units[place],
        values=values,
        errors=errors,
        common_error=common,
        draws=draws,
        median=interval(shifted, shifted.location),
        sigma=spread,
        shape=interval(draws, draws.shape),
        limits=tolerance_limits(shifted, *share),
        chart=control_chart(scores(values, errors, draws)),
        drift=None if times is None else drift(times, values, errors, spread.value),
        outliers=tuple(outliers(values, errors, shape, len(fit.names))),
    )


def _with_common_error(draws: LotDraws, sigma: float) -> LotDraws:
    """Draws of a lot whose estimates share an error."""
    if sigma == 0.0:
        return draws
    shift = sigma * np.random.default_rng(SEED).standard_normal(len(draws.location))
    return LotDraws(draws.location + shift, draws.scale, draws.shape, draws.weight)


def _with_adjusted_drifts(parameters: Mapping[str, LotParameter]) -> dict[str, LotParameter]:
    """Parameters whose drifts have p-values for the whole lot (Holm)."""
    drifts = {name: p.drift for name, p in parameters.items() if p.drift is not None}
    chances = holm([trend.chance for trend in drifts.values()]).tolist()
    adjusted = {
        name: replace(parameters[name], drift=replace(trend, chance=chance))
        for (name, trend), chance in zip(drifts.items(), chances, strict=True)
    }
    return {**parameters, **adjusted}


def _common_errors(fits: Sequence[StoredFit]) -> Vector:
    """Standard deviation of the error of each parameter that all fits share, (p,), SI."""
    variance = np.zeros(len(fits[0].names))
    for name in BENCH:
        sigmas = {fit.tolerances[name].sigma if name in fit.tolerances else None for fit in fits}
        if len(sigmas) == 1 and None not in sigmas:
            variance += np.mean([fit.tolerances[name].errors for fit in fits], axis=0) ** 2
    return np.sqrt(variance)


def _default(names: Sequence[str]) -> str:
    return "coulomb" if "coulomb" in names else names[0]


def _check(fits: Sequence[StoredFit], labels: Sequence[str], shape: str, parameter: str) -> None:
    """Check that the fits are of one lot."""
    if len(fits) < FEWEST:
        raise InputError(
            f"lot: found {len(fits)} wheels, expected at least {FEWEST}: `compare` compares fewer"
        )
    repeated = {label: labels.index(label) for k, label in enumerate(labels) if label in labels[:k]}
    for label, k in repeated.items():
        other = fits[len(labels) - 1 - labels[::-1].index(label)].name
        raise InputError(
            f"{other}: found serial number {label}, expected another than that of {fits[k].name}"
        )
    first = fits[0]
    for fit in fits:
        for what, found, expected in (
            ("friction model", (fit.model,), (first.model,)),
            ("parameters", fit.names, first.names),
            ("units", fit.units, first.units),
        ):
            if found != expected:
                raise InputError(
                    f"{fit.name}: found {what} {', '.join(found)}, expected {', '.join(expected)} "
                    f"as in {first.name}"
                )
    signs = np.sign(np.median([fit.values for fit in fits], axis=0))
    for fit in fits:
        opposite = fit.values * signs < -SURE * np.sqrt(np.diag(fit.covariance))
        for name in np.array(fit.names)[opposite].tolist():
            found = f"{fit.name}: found {name} of another sign than in the lot, expected one sign"
            if name == "motor_constant":
                raise InputError(f"{found}: its current or its speed has the other sign")
            if shape == "log-normal":
                raise InputError(f"{found} in a log-normal one: give --shape unknown")
    for name, spread in zip(first.names, np.ptp([fit.values for fit in fits], axis=0), strict=True):
        if spread == 0.0:
            raise InputError(
                f"lot: found the same {name} in all fits, expected fits of different wheels"
            )
    if parameter and parameter not in first.names:
        raise InputError(
            f"--best: found {parameter!r}, expected one of {', '.join(first.names)} after the rule"
        )
