"""Fit of a waterfall: harmonics are searched, and all kinds of load fitted, in two passes."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.estimates import Estimate
from gyrostat.microvibration.kind_fit import KindFit, fit_kind, with_weights_of
from gyrostat.microvibration.kind_model import SHAPE, KindModel
from gyrostat.microvibration.lines import (
    FEWEST_FLANK,
    line_mask,
    measure_lines,
    number_of,
)
from gyrostat.microvibration.model import DENSITY_UNITS, KINDS, TWO_PI, UNITS
from gyrostat.microvibration.result import Coefficient, FittedHarmonic, FittedKind, WaterfallFit
from gyrostat.microvibration.search import find_harmonics, smooth_density, stationary_bins
from gyrostat.microvibration.waterfall import Waterfall

FEWEST = 8
"""Smallest number of speeds of a valid fit."""
MODE_GAIN = 30.0
"""Decrease of the objective by a mode, of which 12 would be significant at 1 %."""
LARGEST_MISFIT = 0.05
"""Correlation of far residuals from which the density is said not to fit."""
LARGEST_SCATTER = 2.0
NARROW = 2.0
"""Half-power width of a resonance, bins, below which its damping is said to be unresolved."""


def fit_waterfall(waterfall: Waterfall) -> WaterfallFit:
    """Find the harmonics, modes and noise of a wheel.

    Args:
        waterfall: Measured waterfall.

    Returns:
        Estimates; `reasons` says why the result is not valid, if it is not.
    """
    reasons = list(_unusable(waterfall))
    if reasons:
        return WaterfallFit(waterfall, (), {}, tuple(reasons), ())
    models = {kind: smooth_density(density) for kind, (density, _) in waterfall.kinds.items()}
    numbers = find_harmonics(waterfall, models)
    fits: dict[str, KindFit] = {}
    for _ in range(2):
        fits = {kind: _fit(waterfall, kind, models[kind], numbers, fits) for kind in models}
        models = {kind: fit.model.background(fit.values)[0] for kind, fit in fits.items()}
        found = find_harmonics(waterfall, {k: _local(waterfall, k, m) for k, m in models.items()})
        numbers = _refined(fits, numbers, found)
    fits = {kind: _fit(waterfall, kind, models[kind], numbers, fits) for kind in models}
    if not len(numbers):
        reasons.append("no harmonic stands out from the noise")
    loads = {kind: _loads(fit, kind) for kind, fit in fits.items()}
    harmonics = tuple(_harmonic(fits, loads, k) for k in range(len(numbers)))
    kinds = {kind: _kind(kind, fit) for kind, fit in fits.items()}
    return WaterfallFit(waterfall, harmonics, kinds, tuple(reasons), tuple(_warnings(fits)))


def _unusable(waterfall: Waterfall) -> Iterator[str]:
    """Reasons why the waterfall determines no disturbance."""
    count = len(waterfall.speed)
    if count < FEWEST:
        yield f"too few speeds: {count}, at least {FEWEST} are needed"
    needed = 2 * waterfall.window.half_width + 1 + FEWEST_FLANK
    finest = waterfall.speed[-1] / TWO_PI / needed
    if waterfall.step > finest:
        yield (
            f"the resolution of {waterfall.step:.4g} Hz is too coarse to tell harmonics apart: "
            f"at most {finest:.4g} Hz, a segment of at least {1.0 / finest:.3g} s, is needed"
        )


def _local(waterfall: Waterfall, kind: str, model: Matrix) -> Matrix:
    """Density of the model, scaled by what its neighbourhood shows."""
    density = waterfall.kinds[kind][0]
    return np.maximum(model * smooth_density(density / model), 1e-300)


def _fit(
    waterfall: Waterfall,
    kind: str,
    background: Matrix,
    numbers: Vector,
    earlier: dict[str, KindFit],
) -> KindFit:
    """Fit of one kind, with a structural mode where it explains the data much better."""
    density, loads = waterfall.kinds[kind]
    used = (line_mask(waterfall, density, background, numbers) == 0).astype(float)
    stationary = stationary_bins(density)
    used[:, stationary] = 0.0
    before = earlier.get(kind)
    if before is not None:  # the first pass knows no mode yet
        stationary = _stationary(before)
    lines = measure_lines(waterfall, density, background, numbers, stationary)
    model = KindModel(waterfall, density, loads, used, numbers, True, kind == "torque")
    if before is not None:
        return fit_kind(replace(model, has_mode=before.model.has_mode), lines, before.values)
    fit = fit_kind(model, lines)
    plain = fit_kind(replace(model, has_mode=False), lines)
    low, high = TWO_PI * waterfall.frequency[[0, -1]]
    inside = np.log(max(low, 1e-9)) < fit.values[3] < np.log(high)
    better = with_weights_of(fit, plain) - fit.objective > MODE_GAIN
    return fit if inside and better else plain


def _stationary(fit: KindFit) -> NDArray[np.bool_]:
    """Bins of lines that do not move: the peak of a mode is none, however narrow it is, (F,)."""
    density, shown = fit.model.density, fit.model.background(fit.values)[0]
    return stationary_bins(density) & stationary_bins(density / shown)


def _refined(fits: dict[str, KindFit], numbers: Vector, found: Vector) -> Vector:
    """Numbers by the centres of their lines, and those that a better background has shown."""
    better = [_number(fits, k) for k in range(len(numbers))]
    refined = [
        new[0] if np.isfinite(new[0]) else old for new, old in zip(better, numbers, strict=True)
    ]
    resolution = next(iter(fits.values())).model.waterfall
    apart = 2.0 * resolution.window.half_width * resolution.step * TWO_PI / resolution.speed[-1]
    new = [n for n in found if not len(refined) or np.min(np.abs(np.array(refined) - n)) > apart]
    return np.sort(np.array([*refined, *new]))


def _number(fits: dict[str, KindFit], index: int) -> tuple[float, float, float]:
    chosen = list(fits.values())
    speed = chosen[0].model.waterfall.speed
    sigma = [np.sqrt(fit.line_variance) for fit in chosen]
    return number_of(speed, [fit.lines for fit in chosen], sigma, index)


def _harmonic(
    fits: dict[str, KindFit], loads: dict[str, dict[str, tuple[Matrix, Matrix]]], index: int
) -> FittedHarmonic:
    """Estimates of one harmonic."""
    value, sigma, half = _number(fits, index)
    first = next(iter(fits.values())).model
    if not np.isfinite(value):
        value, sigma, half = float(first.numbers[index]), np.inf, np.inf
    number = Estimate(value, sigma, value - half, value + half, "1")
    coefficients = {}
    for kind, fit in fits.items():
        place = len(SHAPE) + index
        pair = [place, place + len(first.numbers)]
        covariance = fit.covariance[np.ix_(pair, pair)]
        unit = UNITS[kind]
        parts = [
            Estimate.of_square(float(fit.values[k]), float(np.sqrt(fit.covariance[k, k])), unit)
            for k in pair
        ]
        total = Estimate.of_square(
            float(fit.values[pair].sum()), float(np.sqrt(covariance.sum())), unit
        )
        alone = int(np.isfinite(fit.lines.power[index]).sum())
        splits = fit.model.has_mode and fit.model.is_gyroscopic
        coefficients[kind] = Coefficient(
            total,
            parts[0],
            parts[1],
            splits,
            alone,
            _each_load(fit, index, kind, total, loads[kind]),
        )
    return FittedHarmonic(number, coefficients)


def _loads(fit: KindFit, kind: str) -> dict[str, tuple[Matrix, Matrix]]:
    """Powers of the lines of each measured load and their variances, (H, S) each."""
    model = fit.model
    background = model.background(fit.values)[0]
    stationary = _stationary(fit)
    result = {}
    for load in KINDS[kind]:
        density = model.waterfall.density.get(load)
        if density is not None:
            lines = measure_lines(model.waterfall, density, background, model.numbers, stationary)
            single = replace(model, loads=1)
            variance = single.power_variance(fit.values, lines, fit.residuals.variance)
            result[load] = lines.power, variance
    return result


def _each_load(
    fit: KindFit,
    index: int,
    kind: str,
    total: Estimate,
    measured: dict[str, tuple[Matrix, Matrix]],
) -> dict[str, Estimate]:
    """Coefficient of each measured load, with the shape over speed that all have in common."""
    shape = np.sum(fit.model.powers(fit.values), axis=0)[index]
    result = {}
    for load, (power, variance) in measured.items():
        good = np.isfinite(power[index])
        weight = shape[good] / variance[index, good]
        information = float(weight @ shape[good])
        if not (information > 0.0 and total.value > 0.0):
            continue
        share = float(weight @ power[index, good]) / information
        spread = np.hypot(1.0 / np.sqrt(information), 2.0 * share * total.sigma / total.value)
        square = total.value**2
        result[load] = Estimate.of_square(square * share, square * float(spread), UNITS[kind])
    return result


def _kind(kind: str, fit: KindFit) -> FittedKind:
    """Estimates of modes and noise of one kind."""
    values, sigma = fit.values, np.sqrt(np.diag(fit.covariance))
    unit = DENSITY_UNITS[kind]
    mode = {}
    if fit.model.has_mode:
        mode["frequency"] = Estimate.of_logarithm(values[3], sigma[3], "rad/s")
        mode["damping"] = Estimate.of_logarithm(values[4], sigma[4], "1")
        if fit.model.is_gyroscopic:
            mode["inertia_ratio"] = Estimate.normal(values[5], sigma[5], "1")
    noise = {
        "floor": Estimate.normal(values[0], sigma[0], unit),
        "density": Estimate.normal(values[1], sigma[1], unit),
    }
    if fit.model.has_mode:
        noise["exponent"] = Estimate.normal(values[2], sigma[2], "1")
    return FittedKind(fit, mode, noise)


def _warnings(fits: dict[str, KindFit]) -> Iterator[str]:
    """What the user should know of a valid fit."""
    for kind, fit in fits.items():
        model = fit.model
        bins = model.waterfall.frequency[_stationary(fit)]
        if len(bins):
            yield f"{kind}: lines that do not move with the speed are left out, at {bins[0]:.4g} Hz"
        if abs(fit.residuals.misfit) > LARGEST_MISFIT:
            yield (
                f"{kind}: the density between the lines does not follow one mode and white noise: "
                "the sigmas of its mode are too small"
            )
        if fit.line_scatter > LARGEST_SCATTER:
            yield (
                f"{kind}: powers of lines scatter by {np.sqrt(fit.line_scatter):.2g} times their "
                "noise; the sigmas are widened by that"
            )
        mode = model.mode(fit.values)
        if mode is not None:
            width = 2.0 * mode.damping * mode.frequency / TWO_PI / model.waterfall.step
            if width < NARROW:
                yield (
                    f"{kind}: the resonance is {width:.2g} bins wide: the resolution is too coarse "
                    "for its damping"
                )
