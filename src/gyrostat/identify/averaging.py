"""Estimates and uncertainty averaged over what may act beside the friction model.

Every hypothesis is a choice of scale (zero: absent) for each nuisance and of level for each random
torque. Linearised at the least-squares fit, each has a Gaussian posterior of the parameters and a
closed-form evidence; the result is the mixture of all of them, weighted by evidence times prior
(Bayesian model averaging: Hoeting et al. 1999, Statistical Science 14). Half of the prior of each
candidate lies on its absence, the other half is spread evenly over its scales, which are decades
apart: what the record does not show costs little, and what it shows is estimated by it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from gyrostat._types import Matrix, Vector
from gyrostat.identify.effects import RIPPLES, STRONG_RIPPLES, Nuisance, TorqueNoise
from gyrostat.identify.innovations import Innovations, innovations
from gyrostat.identify.least_squares import Prior
from gyrostat.identify.prediction import Linearisation

AT_THE_EDGE = 0.5
"""Weight of the strongest torque noise (0.3 before the record is seen) from which stronger ones
are considered."""
CLEARLY_MORE = 3.0
"""Standard deviations by which residuals must exceed a stated noise to overrule it."""


@dataclass(frozen=True)
class Effect:
    """What the records say of one candidate effect.

    Attributes:
        name: Identifier in fit.json.
        title: What a report calls it.
        probability: Posterior probability of its presence; its prior is one half.
        value: Posterior mean of its size given its presence, in its unit; of several coefficients
            the one largest in size.
        sigma: Standard deviation of that coefficient; None for a random torque.
        unit: Of value and sigma; "1" for shares.
    """

    name: str
    title: str
    probability: float
    value: float
    sigma: float | None
    unit: str

    def to_dict(self) -> dict[str, object]:
        """A row of the effects in fit.json."""
        return {
            "name": self.name,
            "title": self.title,
            "probability": self.probability,
            "value": self.value,
            "sigma": self.sigma,
            "unit": self.unit,
        }


@dataclass(frozen=True)
class Average:
    """Mixture over all hypotheses.

    Attributes:
        shift: Mean correction of the estimates, (n,), SI.
        covariance: Of the estimates, (n, n), SI.
        coefficients: Mean coefficients of all nuisances, (m,).
        effects: What the records say of each candidate.
    """

    shift: Vector
    covariance: Matrix
    coefficients: Vector
    effects: tuple[Effect, ...]


@dataclass(frozen=True)
class Segment:
    """One record, linearised at a fit.

    Attributes:
        residual: Measured minus modelled speed, (N,), rad/s; NaN where missing.
        rows: Derivative by the n estimated parameters, (N, n), SI.
        linear: The whole linearisation.
        noise: Random torque at level one.
        sigma: Noise of the measured speed, rad/s: stated, or first guess.
        weight: Weight of each sample under the loss of the fit, (N,).
    """

    residual: Vector
    rows: Matrix
    linear: Linearisation
    noise: TorqueNoise
    sigma: float
    weight: Vector


@dataclass(frozen=True)
class _Posteriors:
    """Posterior of every combination of scales (h of them) at every level of torque noise.

    Attributes:
        mean: (h, n + m) whitened parameters and coefficients.
        covariance: (h, n + m, n + m).
        log_weight: (h,) evidence times prior.
        scales: (h, effects) of each nuisance; zero: absent.
        levels: (h, 2) of ripple and wandering torque.
    """

    mean: Matrix
    covariance: Vector
    log_weight: Vector
    scales: Matrix
    levels: Matrix


def _whitened(
    segments: Sequence[Segment], effects: Sequence[Nuisance], scale: Vector, levels: Matrix
) -> list[Innovations]:
    found = []
    for k, segment in enumerate(segments):
        seen = np.isfinite(segment.residual)
        columns = [np.where(seen, segment.residual, 0.0)[:, None], segment.rows * scale]
        columns += [effect.columns[k] for effect in effects]
        variance = segment.sigma**2 / np.maximum(segment.weight, np.finfo(float).tiny)
        found.append(
            innovations(
                np.column_stack(columns),
                np.where(seen, variance, np.inf),
                segment.linear.transition,
                segment.noise,
                levels,
            )
        )
    return found


def _variance_ratio(own: Innovations, freedom: int, stated: bool) -> Vector:
    """Variance of the prediction errors of a record over the assumed one, for each level, (g,)."""
    size = np.sqrt(np.maximum(np.diagonal(own.products, axis1=1, axis2=2), 1e-300))
    scaled = own.products / (size[:, :, None] * size[:, None, :])
    misfit = []
    for each, length in zip(scaled, size[:, 0], strict=True):
        solved = np.linalg.lstsq(each[1:, 1:], each[1:, 0], rcond=1e-10)[0]
        misfit.append(length**2 * max(1.0 - float(each[0, 1:] @ solved), 1e-12))
    left = max(own.count - freedom, 1)
    ratio = np.array(misfit) / left
    if not stated:
        return ratio
    return np.where(ratio > 1.0 + CLEARLY_MORE * np.sqrt(2.0 / left), ratio, 1.0)


def _posteriors(
    found: Sequence[Innovations],
    effects: Sequence[Nuisance],
    prior: tuple[Matrix, Vector],
    levels: Matrix,
    stated: bool,
) -> _Posteriors:
    information, pull = prior
    count = len(pull)
    widths = [effect.columns[0].shape[1] for effect in effects]
    size = count + sum(widths)
    ratios = [_variance_ratio(each, size, stated) for each in found]
    total = sum(
        each.products / ratio[:, None, None] for each, ratio in zip(found, ratios, strict=True)
    )
    logs = sum(
        each.count * np.log(ratio) + each.log_variance
        for each, ratio in zip(found, ratios, strict=True)
    )
    choices = np.array(list(product(*[(0.0, *effect.scales) for effect in effects])))
    choices = choices.reshape(-1, len(effects))
    spread = np.ones((len(choices), size))
    spread[:, count:] = np.repeat(choices, widths, axis=1)
    # in units of its prior sigma a coefficient that is absent has no column left
    base = np.eye(size)
    base[:count, :count] = information
    chance = np.zeros(len(choices))
    for place, effect in enumerate(effects):
        chance += np.log(np.where(choices[:, place] == 0.0, 0.5, 0.5 / len(effect.scales)))
    parts = []
    for level, products, log in zip(levels, total, logs, strict=True):
        matrix = spread[:, :, None] * products[1:, 1:] * spread[:, None, :] + base
        right = spread * products[1:, 0]
        right[:, :count] += pull
        root = np.linalg.cholesky(matrix)
        inverse = np.linalg.inv(matrix)
        mean = np.einsum("hij,hj->hi", inverse, right)
        determinant = 2.0 * np.sum(np.log(np.diagonal(root, axis1=1, axis2=2)), axis=1)
        evidence = -0.5 * (log + products[0, 0] - np.sum(mean * right, axis=1) + determinant)
        covariance = spread[:, :, None] * inverse * spread[:, None, :]
        own = np.broadcast_to(level, (len(choices), 2))
        parts.append((spread * mean, covariance, evidence + chance + _chance(level), choices, own))
    return _Posteriors(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _chance(level: Vector) -> float:
    """Logarithm of the prior probability of a pair of levels, but for a constant."""
    return float(np.sum(np.where(level == 0.0, 0.0, -np.log(len(RIPPLES)))))


def _grid(ripples: Sequence[float]) -> Matrix:
    """Pairs of levels of the ripple at crossings and of the wandering torque."""
    every = (0.0, *ripples)
    return np.array(list(product(every, every)))


def average(
    segments: Sequence[Segment],
    effects: Sequence[Nuisance],
    prior: Prior,
    x: Vector,
    scale: Vector,
    *,
    stated: bool,
) -> Average:
    """Average estimates over all hypotheses.

    Args:
        segments: All records, linearised at the same fit.
        effects: Candidates of definite shape.
        prior: A-priori knowledge of the n estimated parameters.
        x: (n,) estimates of the fit, SI.
        scale: (n,) sizes that the parameters could have, SI.
        stated: Whether the user stated the noise of the speed: then it is only raised where the
            residuals clearly exceed it.
    """
    rows = prior.rows() * scale
    known = (rows.T @ rows, -rows.T @ prior.residual(x))
    levels = _grid(RIPPLES)
    seen = _posteriors(_whitened(segments, effects, scale, levels), effects, known, levels, stated)
    weight = _weights(seen)
    if weight[np.max(seen.levels, axis=1) == RIPPLES[-1]].sum() > AT_THE_EDGE:
        levels = _grid((*RIPPLES, *STRONG_RIPPLES))
        found = _whitened(segments, effects, scale, levels)
        seen = _posteriors(found, effects, known, levels, stated)
        weight = _weights(seen)
    count = len(x)
    mean = weight @ seen.mean
    apart = seen.mean - mean
    inside = np.einsum("h,hij->ij", weight, seen.covariance)
    covariance = inside + np.einsum("h,hi,hj->ij", weight, apart, apart)
    return Average(
        shift=scale * mean[:count],
        covariance=np.outer(scale, scale) * covariance[:count, :count],
        coefficients=mean[count:],
        effects=(*_found(seen, weight, effects, count), *_torques(seen, weight)),
    )


def _weights(seen: _Posteriors) -> Vector:
    weight = np.exp(seen.log_weight - seen.log_weight.max())
    return weight / weight.sum()


def _found(
    seen: _Posteriors, weight: Vector, effects: Sequence[Nuisance], count: int
) -> list[Effect]:
    """What the mixture says of each nuisance, given its presence."""
    found, first = [], count
    for place, effect in enumerate(effects):
        last = first + effect.columns[0].shape[1]
        own = weight * (seen.scales[:, place] > 0.0)
        share = own / max(own.sum(), np.finfo(float).tiny)
        mean = share @ seen.mean[:, first:last]
        largest = int(np.argmax(np.abs(mean)))
        at = first + largest
        apart = seen.mean[:, at] - mean[largest]
        variance = float(share @ (seen.covariance[:, at, at] + apart**2))
        value, sigma = float(mean[largest]), float(np.sqrt(variance))
        chance = float(min(own.sum(), 1.0))
        found.append(Effect(effect.name, effect.title, chance, value, sigma, effect.unit))
        first = last
    return found


def _torques(seen: _Posteriors, weight: Vector) -> list[Effect]:
    """What the mixture says of the random torques, given their presence."""
    found = []
    for place, (name, title) in enumerate(
        (
            ("crossing_ripple", "torque ripple near zero speed, share of the friction torque"),
            ("torque_walk", "torque that wanders over the record, share of the friction torque"),
        )
    ):
        level = seen.levels[:, place]
        own = weight * (level > 0.0)
        chance = float(min(own.sum(), 1.0))
        value = float(own @ level / max(own.sum(), np.finfo(float).tiny))
        found.append(Effect(name, title, chance, value, None, "1"))
    return found
