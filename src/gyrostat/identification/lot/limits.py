"""Tolerance limits: limits that contain a share of the wheels of a lot, with stated confidence.

Limits from the draws of `posterior` include the errors of the fits, which are taken out of the
spread of the wheels, and the uncertainty of the lot. The classical factors k, for limits at mean
plus k standard deviations of the estimates (ISO 16269-6; R. E. Odeh and D. B. Owen, 1980, Tables
for Normal Tolerance Limits), are for normal lots whose parameters are measured without errors.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import brentq
from scipy.special import chdtrc, nctdtrit, ndtr, ndtri

from gyrostat.core.pictured import Described
from gyrostat.core.skewed_normal import score_of, value_at
from gyrostat.identification.lot.posterior import LotDraws

CONTENT, CONFIDENCE = 0.95, 0.95
HALVINGS = 20


@dataclass(frozen=True)
class Limits(Described):
    """Tolerance limits of one parameter, SI.

    Attributes:
        lower: The stated share of the wheels is above it.
        upper: The stated share of the wheels is below it.
        low: Lower end of the interval that contains the stated share.
        high: Upper end of this interval.
    """

    lower: float
    upper: float
    low: float
    high: float


def tolerance_limits(draws: LotDraws, content: float, confidence: float) -> Limits:
    """One-sided limits, and an interval.

    Args:
        draws: Draws of the lot.
        content: Share of the wheels, between 0.5 and 1.
        confidence: Probability that the limits contain this share.
    """
    inner, doubt = 0.5 * (1.0 + content), 1.0 - confidence
    shares = (1.0 - content, content, 1.0 - inner, inner)
    lower, upper, low, high = (
        draws.quantiles(value_at(ndtri(share), *draws.lots.T)) for share in shares
    )
    # ends with equal doubt in the outer shares; the share inside, not the two outer ones, is sure
    fewest, most = 0.0, 0.5
    for _ in range(HALVINGS):
        middle = 0.5 * (fewest + most)
        ends = low(middle), high(1.0 - middle)
        below, above = (ndtr(score_of(end, *draws.lots.T)) for end in ends)
        sure = float(draws.weight @ (above - below >= content))
        fewest, most = (middle, most) if sure >= confidence else (fewest, middle)
    return Limits(lower(doubt), upper(1.0 - doubt), low(fewest), high(1.0 - fewest))


def one_sided_factor(count: int, content: float, confidence: float) -> float:
    """Classical factor of a one-sided limit, by the noncentral t distribution.

    Args:
        count: Number of wheels, at least 2.
        content: Share of the wheels.
        confidence: Confidence.
    """
    noncentrality = float(np.sqrt(count) * ndtri(content))
    return float(nctdtrit(count - 1, noncentrality, confidence) / np.sqrt(count))


def two_sided_factor(count: int, content: float, confidence: float) -> float:
    """Classical factor of an interval about the mean; see `one_sided_factor` for the arguments.

    The confidence is the mean, over the error of the sample mean, of the probability that the
    sample standard deviation is large enough.
    """
    means = np.linspace(-8.0, 8.0, 401)
    weight = np.exp(-0.5 * means**2) / np.exp(-0.5 * means**2).sum()
    offset = np.abs(means) / np.sqrt(count)
    low, high = np.zeros_like(offset), offset + 10.0
    for _ in range(60):
        half = 0.5 * (low + high)
        is_enough = ndtr(offset + half) - ndtr(offset - half) >= content
        low, high = np.where(is_enough, low, half), np.where(is_enough, half, high)

    def excess(factor: float) -> float:
        least = (count - 1) * (high / factor) ** 2
        return float(weight @ chdtrc(count - 1, least)) - confidence

    root: Any = brentq(excess, 0.1, 1000.0)
    return float(root)
