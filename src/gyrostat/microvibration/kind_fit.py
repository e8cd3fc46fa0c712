"""Fit of one kind of load: densities between the lines and powers of the lines together."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.kind_model import SHAPE, KindModel
from gyrostat.microvibration.lines import Lines
from gyrostat.microvibration.residuals import Background, Residuals
from gyrostat.microvibration.start import start_values

STEPS = 60
"""Largest number of iterations."""
STEP = 1e-5
"""Difference of ln frequency, ln damping and inertia ratio for a derivative."""
SETTLED = 1e-7
"""Relative decrease of the objective below which the fit has converged."""
REJECTED = 9.0
"""Increase of a sum of squares, of one degree of freedom, by which a sense of whirl is rejected."""


@dataclass(frozen=True, eq=False)
class KindFit:
    """Fitted parameters of one kind of load.

    Attributes:
        model: Model with the data.
        values: Parameters; see `KindModel`.
        covariance: Their covariance; parameters that are held have none.
        lines: Measured lines.
        line_variance: Variance of their powers, (H, S).
        residuals: Statistics of the residuals between the lines.
        objective: Value that was minimised.
        line_scatter: Mean square of the residuals of the lines over their variance.
    """

    model: KindModel
    values: Vector
    covariance: Matrix
    lines: Lines
    line_variance: Matrix
    residuals: Residuals
    objective: float
    line_scatter: float


def fit_kind(model: KindModel, lines: Lines, start: Vector | None = None) -> KindFit:
    """Fit one kind of load, and choose the sense in which each harmonic whirls.

    Args:
        model: Model with its data.
        lines: Measured lines.
        start: Start values of the parameters of the density; None to search for them.
    """
    values = start_values(model) if start is None else _with_shape(model, start)
    count = len(model.numbers)
    senses = np.zeros((2, count), dtype=bool)
    senses[0] = np.isfinite(lines.power).sum(axis=1) > 0
    residuals = Residuals.of(model, model.background(values))
    values = _coefficients(model, values, lines, senses, residuals)
    fit = _minimise(model, values, lines, senses)
    if model.has_mode and model.is_gyroscopic:
        better = _choose_senses(fit, senses)
        if np.any(better != senses):
            values = _coefficients(model, fit.values, lines, better, fit.residuals)
            fit = _minimise(model, values, lines, better)
    return fit


def _with_shape(model: KindModel, start: Vector) -> Vector:
    """Parameters of the density, coefficients 0."""
    return np.concatenate([start[: len(SHAPE)], np.zeros(2 * len(model.numbers))])


def with_weights_of(fit: KindFit, other: KindFit) -> float:
    """Objective of another fit of the same data with the variances of the first."""
    weights = _Weights(fit.residuals, fit.line_variance, np.isfinite(fit.lines.power))
    background = other.model.background(other.values)
    return _objective(other.model, other.values, background, other.lines, weights)


def _coefficients(
    model: KindModel, values: Vector, lines: Lines, senses: Any, residuals: Residuals
) -> Vector:
    """Parameters with squared coefficients by weighted least squares, twice for the weights."""
    values = values.copy()
    gains = model.line_gains(values)
    # at first as if each line were all signal
    values[len(SHAPE) :] = 0.0
    for _ in range(3):
        variance = model.power_variance(values, lines, residuals.variance)
        for k in range(len(model.numbers)):
            good = np.isfinite(lines.power[k])
            chosen = [s for s in (0, 1) if senses[s, k]]
            if not chosen or not good.any():
                continue
            root = np.sqrt(variance[k, good])
            matrix = np.array([gains[s][k, good] / root for s in chosen]).T
            scale = np.linalg.norm(matrix, axis=0)
            result = np.linalg.lstsq(matrix / scale, lines.power[k, good] / root, rcond=1e-10)
            for s, value in zip(chosen, result[0] / scale, strict=True):
                values[len(SHAPE) + s * len(model.numbers) + k] = max(float(value), 0.0)
    return values


def _choose_senses(fit: KindFit, senses: Any) -> Any:
    """Senses of each harmonic by the residuals of its line at fixed mode.

    One sense alone is taken where the other is rejected and both together are no better.
    """
    model, lines = fit.model, fit.lines
    scores = {}
    for pattern in ((True, False), (False, True), (True, True)):
        trial = np.array(pattern)[:, None] & senses[0]
        values = _coefficients(model, fit.values, lines, trial, fit.residuals)
        # common weights, so that the sums of squares compare
        residual = lines.power - sum(model.powers(values))
        scores[pattern] = np.nansum(residual**2 / fit.line_variance, axis=1)
    forward, backward, both = scores.values()
    alone = np.minimum(forward, backward) - both < REJECTED
    is_forward = alone & (backward - forward > REJECTED)
    is_backward = alone & (forward - backward > REJECTED)
    return np.array([~is_backward, ~is_forward]) & senses[0]


def _minimise(model: KindModel, values: Vector, lines: Lines, senses: Any) -> KindFit:
    """Fisher scoring with damping; the weights follow the model."""
    free = np.zeros(len(values), dtype=bool)
    free[: 6 if model.is_gyroscopic else 5] = True
    if not model.has_mode:
        free[2:6] = False
    free[len(SHAPE) :] = senses.ravel()
    damping, best = 1e-3, np.inf
    good = np.isfinite(lines.power)
    background = model.background(values)
    for _ in range(STEPS):
        residuals = Residuals.of(model, background)
        variance = model.power_variance(values, lines, residuals.variance)
        weights = _Weights(residuals, variance, good)
        best = _objective(model, values, background, lines, weights)
        gradient, information = _scores(model, values, background, lines, weights, free)
        scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
        moved, trial, value, shown = False, values, best, background
        while damping < 1e8 and not moved:
            system = information / np.outer(scale, scale) + damping * np.eye(len(scale))
            step = np.linalg.solve(system, gradient / scale) / scale
            trial = values.copy()
            trial[free] += step
            trial = _bounded(trial, values)
            shown = model.background(trial)
            value = _objective(model, trial, shown, lines, weights)
            moved = value < best
            damping = damping * 0.1 if moved else damping * 10.0
        if not moved:
            break
        values, background = trial, shown
        if best - value < SETTLED * abs(best):
            break
    return _result(model, values, background, lines, free)


@dataclass(frozen=True)
class _Weights:
    """Variances that an iteration holds."""

    residuals: Residuals
    variance: Matrix
    good: Any


def _bounded(trial: Vector, values: Vector) -> Vector:
    """Parameters within their bounds, which a step approaches by half."""
    trial = trial.copy()
    trial[0] = max(trial[0], 0.3 * values[0], 1e-300)
    trial[1] = max(trial[1], 0.0)
    trial[2] = np.clip(trial[2], -1.0, 8.0)
    trial[3:5] = np.clip(trial[3:5], values[3:5] - 0.5, values[3:5] + 0.5)
    trial[4] = np.clip(trial[4], np.log(1e-4), np.log(2.0))
    trial[5] = np.clip(trial[5], 0.0, 2.0)
    trial[6:] = np.maximum(trial[6:], 0.0)
    return trial


def _objective(
    model: KindModel, values: Vector, background: Background, lines: Lines, weights: _Weights
) -> float:
    """Quasi-deviance of the densities and squares of the lines."""
    shown, shape = background
    ratio = np.maximum(model.density, 1e-300) / shown
    parts = 2.0 * model.used * (ratio - 1.0 - np.log(ratio)) / shape
    density = float(np.sum(parts)) / weights.residuals.variance
    residual = np.where(weights.good, lines.power - sum(model.powers(values)), 0.0)
    return density + float(np.sum(residual**2 / np.where(weights.good, weights.variance, 1.0)))


def _scores(
    model: KindModel,
    values: Vector,
    background: Background,
    lines: Lines,
    weights: _Weights,
    free: Any,
) -> tuple[Vector, Matrix]:
    """Gradient for a step and expected information of the free parameters."""
    shown, shape = background
    weight = np.sqrt(model.used / (shape * weights.residuals.variance)) / shown
    root = np.where(weights.good, 1.0 / np.sqrt(np.where(weights.good, weights.variance, 1.0)), 0.0)
    powers = sum(model.powers(values))
    residual = [
        (weight * (model.density - shown)).ravel(),
        (root * np.where(weights.good, lines.power - powers, 0.0)).ravel(),
    ]
    index = np.flatnonzero(free)
    dense = index[index < len(SHAPE)]
    columns = np.zeros((len(index), residual[1].size))
    slopes = np.zeros((len(dense), residual[0].size))
    count = len(model.numbers)
    gains = model.line_gains(values)
    linear = model.level_slopes(values)
    for row, k in enumerate(index):
        if k >= len(SHAPE):
            sense, harmonic = divmod(int(k) - len(SHAPE), count)
            part = np.zeros_like(powers)
            part[harmonic] = gains[sense][harmonic]
            columns[row] = (root * part).ravel()
            continue
        if k < len(linear):
            slopes[row] = (weight * linear[k]).ravel()
            continue
        trial = values.copy()
        trial[k] += STEP
        slopes[row] = (weight * (model.background(trial)[0] - shown) / STEP).ravel()
        columns[row] = (root * (sum(model.powers(trial)) - powers) / STEP).ravel()
    information = columns @ columns.T
    information[: len(dense), : len(dense)] += slopes @ slopes.T
    gradient = columns @ residual[1]
    gradient[: len(dense)] += slopes @ residual[0]
    return gradient, information


def _result(
    model: KindModel, values: Vector, background: Background, lines: Lines, free: Any
) -> KindFit:
    residuals = Residuals.of(model, background)
    variance = model.power_variance(values, lines, residuals.variance)
    good = np.isfinite(lines.power)
    line_residual = np.where(good, lines.power - sum(model.powers(values)), 0.0)
    squares = line_residual**2 / np.where(good, variance, 1.0)
    freedom = int(good.sum()) - int(free[len(SHAPE) :].sum())
    scatter = float(squares.sum()) / freedom if freedom > 0 else 1.0
    weights = _Weights(residuals, variance * max(scatter, 1.0), good)
    _, information = _scores(model, values, background, lines, weights, free)
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / np.outer(scale, scale), rcond=1e-12, hermitian=True)
    covariance = np.zeros((len(values), len(values)))
    covariance[np.ix_(free, free)] = inverse / np.outer(scale, scale)
    objective = _objective(model, values, background, lines, weights)
    return KindFit(
        model,
        values,
        covariance,
        lines,
        variance,
        residuals,
        objective,
        scatter,
    )
