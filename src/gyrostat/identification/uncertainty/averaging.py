"""Bayesian model averaging of estimates and uncertainty over effects outside the friction model.

Every hypothesis is a choice of scale (zero: absent) for each nuisance and of level for each random
torque. Linearised at the least-squares fit, each has a Gaussian posterior of the parameters and a
closed-form evidence. The result is the mixture of all of them, weighted by evidence times prior
(Hoeting et al. 1999, Statistical Science 14). Each candidate is present with a probability that is
itself unknown and common to all. A record that shows one effect thus makes the others more likely,
and a record without effects makes them less likely (Scott and Berger 2010, Annals of Statistics
38). The prior of a present candidate is uniform over its scales, which are decades apart, but for
the ripple at zero crossings (`LARGEST_RIPPLE_ODDS`, `RESOLVED`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.pictured import Listed
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.fit.least_squares import Prior
from gyrostat.identification.read.findings import Finding, Score
from gyrostat.identification.uncertainty.diagnosis import TORQUES, diagnose
from gyrostat.identification.uncertainty.effects import RESOLVED, RIPPLES, STRONG_RIPPLES, Nuisance
from gyrostat.identification.uncertainty.hypotheses import (
    Posteriors,
    Segment,
    grid,
    posteriors,
    whitened,
)

AT_THE_EDGE = 0.73
"""Posterior weight of the strongest torque noise (0.63 a priori) above which stronger levels are
considered."""


@dataclass(frozen=True)
class Effect(Listed):
    """Posterior of one candidate effect.

    Attributes:
        name: Identifier in fit.json.
        title: Title in reports.
        probability: Posterior probability of its presence; 2/3 a priori, more for the ripple in a
            record that resolves torques at rest finely.
        value: Posterior mean of its size if it is present, in `unit`; the largest in size of
            several coefficients; of a random torque, the root mean square.
        sigma: Standard deviation of that coefficient; None for a random torque.
        unit: Unit of value and sigma; "1" for fractions.
        prior: Standard deviation a priori; None for a random torque and where several are possible.
    """

    name: str
    title: str
    probability: float
    value: float
    sigma: float | None
    unit: str
    prior: float | None = None

    @property
    def likely(self) -> bool:
        """Whether it is more likely present than absent."""
        return self.probability > 0.5

    @property
    def expected(self) -> float:
        """Root mean square of its size over the posterior, where it may be absent, in `unit`."""
        return float(np.sqrt(self.probability) * np.hypot(self.value, self.sigma or 0.0))


@dataclass(frozen=True)
class Average:
    """Mixture over all hypotheses.

    Attributes:
        shift: Mean correction of the estimates, (n,), SI.
        covariance: Covariance of the estimates, (n, n), SI.
        coefficients: Mean coefficients of all nuisances, (m,).
        effects: Posterior of each candidate.
        findings: Effects that the diagnosis found, averaged or not.
        scores: Score tests of all candidates.
    """

    shift: Vector
    covariance: Matrix
    coefficients: Vector
    effects: tuple[Effect, ...]
    findings: tuple[Finding, ...] = ()
    scores: tuple[Score, ...] = ()


def average(
    segments: Sequence[Segment],
    effects: Sequence[Nuisance],
    prior: Prior,
    x: Vector,
    scale: Vector,
    *,
    stated: bool,
    beside: Sequence[Nuisance] = (),
    names: Sequence[str] = (),
    ripple: float | None = None,
    resolution: float = np.inf,
) -> Average:
    """Average estimates over all hypotheses, and diagnose the residuals.

    Args:
        segments: All records, linearised at the same fit.
        effects: Deterministic candidates.
        prior: A-priori knowledge of the n estimated parameters.
        x: Estimates of the fit, (n,), SI.
        scale: Plausible sizes of the parameters, (n,), SI.
        stated: Whether the user stated the noise of the speed. It is then increased only if the
            residuals clearly exceed it.
        beside: Further candidates, which are diagnosed but not averaged.
        names: Names of the estimated parameters; without them there is no diagnosis.
        ripple: Level of the ripple at zero crossings; None: averaged over.
        resolution: Standard deviation of a torque at rest in white noise, fraction of the dry
            friction (`RESOLVED`).
    """
    rows = prior.rows() * scale
    prior_information = (rows.T @ rows, -rows.T @ prior.residual(x))
    every = [*effects, *beside]
    count = len(x)
    size = 1 + count + sum(effect.columns[0].shape[1] for effect in effects)

    def mixture() -> tuple[Posteriors, Vector]:
        columns = [each.leading(size) for each in innovations]
        odds = _odds(levels, ripple, resolution)
        hypotheses = posteriors(columns, effects, prior_information, levels, stated, odds)
        weight = np.exp(hypotheses.log_weight - hypotheses.log_weight.max())
        return hypotheses, weight / weight.sum()

    levels = grid(RIPPLES, ripple)
    innovations = whitened(segments, every, scale, levels)
    hypotheses, weight = mixture()
    free = hypotheses.levels if ripple is None else hypotheses.levels[:, 1:]
    if weight[np.max(free, axis=1) == RIPPLES[-1]].sum() > AT_THE_EDGE:
        wider = grid((*RIPPLES, *STRONG_RIPPLES), ripple)
        further = wider[~np.any(np.all(wider[:, None] == levels, axis=2), axis=1)]
        extra = whitened(segments, every, scale, further)
        levels = np.vstack([levels, further])
        innovations = [a.with_levels(b) for a, b in zip(innovations, extra, strict=True)]
        hypotheses, weight = mixture()
    findings, scores = (), ()
    if names:
        findings, scores = diagnose(
            innovations, levels, every, prior_information, names, scale, stated=stated
        )
    mean = weight @ hypotheses.mean
    apart = (hypotheses.mean - mean)[:, :count]
    inside = np.einsum("h,hij->ij", weight, hypotheses.covariance)
    covariance = inside + (weight[:, None] * apart).T @ apart
    return Average(
        shift=scale * mean[:count],
        covariance=np.outer(scale, scale) * covariance,
        coefficients=mean[count:],
        effects=(
            *_effect_marginals(hypotheses, weight, effects, count),
            *_torque_marginals(hypotheses, weight),
        ),
        findings=findings,
        scores=scores,
    )


def _odds(levels: Matrix, ripple: float | None, resolution: float) -> Vector:
    """Logarithm of the prior odds of each level; only those with a stated ripple are possible."""
    still = 2.0 * np.log(min(1.0, resolution / RESOLVED))
    odds = np.where(levels[:, 0] > 0.0, 0.0, still)
    return odds if ripple is None else np.where(levels[:, 0] == ripple, odds, -np.inf)


def _effect_marginals(
    hypotheses: Posteriors, weight: Vector, effects: Sequence[Nuisance], count: int
) -> list[Effect]:
    """Posterior of each nuisance, given its presence."""
    marginals, first = [], count
    for index, effect in enumerate(effects):
        last = first + effect.columns[0].shape[1]
        weight_present = weight * (hypotheses.scales[:, index] > 0.0)
        share = weight_present / max(weight_present.sum(), np.finfo(float).tiny)
        shift = share @ hypotheses.mean[:, first:last]
        mean = shift if effect.at is None else effect.at + shift
        largest = int(np.argmax(np.abs(mean)))
        at = first + largest
        apart = hypotheses.mean[:, at] - shift[largest]
        variance = float(share @ (hypotheses.variance[:, at] + apart**2))
        value, sigma = float(mean[largest]), float(np.sqrt(variance))
        chance = float(min(weight_present.sum(), 1.0))
        prior = effect.scales[0] if len(effect.scales) == 1 else None
        row = (effect.name, effect.title, chance, value, sigma, effect.unit, prior)
        marginals.append(Effect(*row))
        first = last
    return marginals


def _torque_marginals(hypotheses: Posteriors, weight: Vector) -> list[Effect]:
    """Posterior of the random torques, given their presence."""
    marginals = []
    for index, (name, title) in enumerate(TORQUES):
        level = hypotheses.levels[:, index]
        weight_present = weight * (level > 0.0)
        chance = float(min(weight_present.sum(), 1.0))
        mean_square = weight_present @ level**2 / max(weight_present.sum(), np.finfo(float).tiny)
        value = float(np.sqrt(mean_square))
        marginals.append(Effect(name, title, chance, value, None, "1"))
    return marginals
