"""Hypotheses on effects outside the friction model: their posteriors and evidence."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from math import lgamma

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.prediction import Linearisation
from gyrostat.identification.uncertainty.effects import LARGEST_RIPPLE_ODDS, RIPPLES, Nuisance
from gyrostat.identification.uncertainty.innovations import Innovations, innovations
from gyrostat.identification.uncertainty.regressions import Regressions
from gyrostat.identification.uncertainty.torque_noise import TorqueNoise

PRESENT, ABSENT = 0.5, 0.25
"""Parameters of the Beta prior of the probability of presence of a candidate. It is wide, with mean
2/3, because real wheels have most of the effects."""
NEGLIGIBLE = 20.0
"""Hypotheses whose probability is smaller than that of the best by exp(20) are left out."""
CLEARLY_MORE = 3.0
"""Standard deviations by which residuals must exceed a stated noise to replace it."""


@dataclass(frozen=True)
class Segment:
    """One record, linearised at a fit.

    Attributes:
        residual: Measured minus modelled speed, (N,), rad/s; NaN where missing.
        rows: Derivative of the speed by the n estimated parameters, (N, n), SI.
        linear: Linearisation over all parameters.
        noise: Random torque at level one.
        sigma: Noise of the measured speed, stated or a first estimate, rad/s.
        weight: Weight of each sample under the loss of the fit, over the number of samples that
            share one error, (N,).
        samples: Number of independent errors of the speed; None: one for each sample.
        smallest: Smallest noise of the measured speed, rad/s.
    """

    residual: Vector
    rows: Matrix
    linear: Linearisation
    noise: TorqueNoise
    sigma: float
    weight: Vector
    samples: float | None = None
    smallest: float = 0.0


@dataclass(frozen=True)
class Posteriors:
    """Posterior of combinations of scales at levels of torque noise, h of them.

    Attributes:
        mean: Whitened parameters and coefficients, (h, n + m).
        covariance: Covariance of the parameters, (h, n, n).
        variance: Variance of each of `mean`, (h, n + m).
        log_weight: Logarithm of evidence times prior, (h,).
        scales: Scale of each nuisance, (h, effects); zero: absent.
        levels: Levels of ripple and random-walk torque, (h, 2).
    """

    mean: Matrix
    covariance: Vector
    variance: Matrix
    log_weight: Vector
    scales: Matrix
    levels: Matrix


def whitened(
    segments: Sequence[Segment], effects: Sequence[Nuisance], scale: Vector, levels: Matrix
) -> list[Innovations]:
    """Whiten the residual and the derivatives of each record for each pair of levels.

    Args:
        segments: All records, linearised at the same fit.
        effects: Deterministic candidates.
        scale: Plausible sizes of the parameters, (n,), SI.
        levels: Levels of ripple and random-walk torque, (g, 2).
    """
    results = []
    for k, segment in enumerate(segments):
        valid = np.isfinite(segment.residual)
        columns = [np.where(valid, segment.residual, 0.0)[:, None], segment.rows * scale]
        columns += [effect.columns[k] for effect in effects]
        variance = segment.sigma**2 / np.maximum(segment.weight, np.finfo(float).tiny)
        found = innovations(
            columns,
            np.where(valid, variance, np.inf),
            segment.linear.transition,
            segment.noise,
            levels,
        )
        least = (segment.smallest / segment.sigma) ** 2
        samples = found.samples if segment.samples is None else segment.samples
        results.append(found._replace(samples=samples, least=least))
    return results


def _variance_ratio(record: Innovations, stated: bool) -> Vector:
    """Variance of the prediction errors of a record over the assumed one, for each level, (g,).

    Args:
        record: Whitened columns of the record.
        stated: Whether the user stated the noise. It is then increased only if the errors clearly
            exceed it.
    """
    size = np.sqrt(np.maximum(np.diagonal(record.products, axis1=1, axis2=2), 1e-300))
    correlation = record.products / (size[:, :, None] * size[:, None, :])
    misfit = []
    for each, length in zip(correlation, size[:, 0], strict=True):
        solution = np.linalg.lstsq(each[1:, 1:], each[1:, 0], rcond=1e-10)[0]
        misfit.append(length**2 * max(1.0 - float(each[0, 1:] @ solution), 1e-12))
    freedom = max(record.samples - (record.products.shape[1] - 1), 1)
    ratio = np.maximum(np.array(misfit) / freedom, record.least)
    if not stated:
        return ratio
    return np.where(ratio > 1.0 + CLEARLY_MORE * np.sqrt(2.0 / freedom), ratio, 1.0)


def summed(found: Sequence[Innovations], stated: bool) -> tuple[Vector, Vector]:
    """Products, (g, 1 + c, 1 + c), and log variances, (g,), of all records at their own noise.

    Args:
        found: Whitened residual and c columns of each record at g levels of torque noise.
        stated: Whether the user stated the noise of the speed.
    """
    pairs = [(each, _variance_ratio(each, stated)) for each in found]
    total = np.sum([each.products / ratio[:, None, None] for each, ratio in pairs], axis=0)
    logs = [each.samples * np.log(ratio) + each.log_variance for each, ratio in pairs]
    return total, np.sum(logs, axis=0)


def _choices(effects: Sequence[Nuisance]) -> Matrix:
    """Every choice of the scales of all effects, (h, effects); zero: absent."""
    options = [e.scales if e.at is not None else (0.0, *e.scales) for e in effects]
    choices = np.array(list(product(*options))).reshape(-1, len(effects))
    names = [effect.name for effect in effects]
    for k, effect in enumerate(effects):
        if effect.beside is not None:
            same = choices[:, k] == choices[:, names.index(effect.beside)]
            choices = choices[(choices[:, k] == 0.0) | same]
    return choices


def posteriors(
    found: Sequence[Innovations],
    effects: Sequence[Nuisance],
    prior: tuple[Matrix, Vector],
    levels: Matrix,
    stated: bool,
    odds: Vector,
) -> Posteriors:
    """Posterior of every hypothesis that matters: each choice of scales at each pair of levels.

    Args:
        found: Whitened columns of each record.
        effects: Deterministic candidates.
        prior: Information matrix of the whitened parameters, (n, n), and the information vector,
            (n,).
        levels: Levels of ripple and random-walk torque, (g, 2).
        stated: Whether the user stated the noise of the speed.
        odds: Logarithm of further prior odds of each level, (g,).
    """
    total, logs = summed(found, stated)
    choices = _choices(effects)
    widths = [effect.columns[0].shape[1] for effect in effects]
    means = [np.zeros(w) if e.at is None else -e.at for e, w in zip(effects, widths, strict=True)]
    regressions = Regressions(total, *prior, widths, choices, means)
    counted = [e.beside is None and e.odds is None for e in effects]
    sizes = np.array([len(effect.scales) for effect in effects])[counted]
    sizes = np.append(sizes, (len(RIPPLES), len(RIPPLES)))
    sampled = (choices > 0.0) @ [np.log(e.odds / len(e.scales)) if e.odds else 0.0 for e in effects]
    weights = []
    for level, log, further in zip(levels, logs, odds, strict=True):
        rows = np.broadcast_to(level, (len(choices), 2))
        present = np.column_stack([choices[:, counted], rows]) > 0.0
        chance = _presence(present) - present @ np.log(sizes)
        if level[0] == RIPPLES[-1]:
            chance = chance + np.log(LARGEST_RIPPLE_ODDS)
        weights.append(chance + sampled + further - 0.5 * log)
    weight = np.array(weights) - 0.5 * regressions.deviances()
    level, which = np.nonzero(weight > weight.max() - NEGLIGIBLE)
    moments = regressions.moments(level, which)
    return Posteriors(*moments, weight[level, which], choices[which], levels[level])


def _presence(present: NDArray[np.bool_]) -> Vector:
    """Logarithm of the prior probability of patterns of presence, up to a constant.

    Args:
        present: Whether each of k candidates is present, (h, k).

    Returns:
        Value for each pattern, (h,), with the common probability of presence integrated out.
    """
    count = present.shape[1]
    table = [lgamma(k + PRESENT) + lgamma(count - k + ABSENT) for k in range(count + 1)]
    return np.array(table)[present.sum(axis=1)]


def grid(ripples: Sequence[float], stated: float | None = None) -> Matrix:
    """Pairs of levels of the ripple at crossings and of the random-walk torque.

    Args:
        ripples: Levels above zero.
        stated: Further level of the ripple.
    """
    every = (0.0, *ripples)
    values = every if stated is None else sorted({*every, stated})
    return np.array(list(product(values, every)))
