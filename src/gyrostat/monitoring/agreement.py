"""Estimate of a window beside what was known beforehand: used where the data agree with it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.estimate import APART, estimate, explains
from gyrostat.monitoring.moments import LAG, Prior, stated
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.regression import Estimate, Rows
from gyrostat.monitoring.rounding import widened

OBSERVABLE = 0.3
"""Largest standard deviation of an observable parameter, over its value."""
TOLD = 0.75
"""Share of the variance of what was known beforehand that data must remove to contradict it."""
LATE = 2.0
"""Lag of the current, in its sigma beforehand, above which telemetry alone tells it."""
LOST, AGREEING = 1.05, 2.5
"""Variance of a parameter over that beforehand above which rounding has made it worse, and
difference from what was known, in its sigma, below which that holds in its place."""


def agreeing_estimate(
    rows: Rows, prior: Prior, noise: Noise, errors_of: Callable[[Estimate], Matrix]
) -> Estimate:
    """Estimate; without what was known beforehand of a parameter where the data contradict.

    Args:
        rows: Rows of the regression.
        prior: What is known beforehand.
        noise: Noise from which the search starts.
        errors_of: Errors of the response for an estimate, as `widened` takes them.
    """

    def found(known: Prior, start: Vector, noise: Noise) -> Estimate:
        value = estimate(rows, known, start, noise)
        wide = widened(rows, value, errors_of(value))
        # what contradicts without the errors by rounding alone is explained by them
        if _contradicts(value, known) and not _contradicts(wide, known):
            value = estimate(rows, known, known.mean.copy(), noise, believe=True)
            wide = widened(rows, value, errors_of(value))
        places: list[int] = []
        while worse := _worse(wide, places):
            places += worse
            wide = _as_stated(rows, value, places, errors_of)
        return wide

    value = found(prior, prior.mean.copy(), noise)
    prior = value.prior
    wrong, pulled = _apart(value, prior)
    if wrong:
        other = found(prior.without(wrong), value.value, value.noise)
        sigma = np.sqrt(np.diagonal(other.covariance))[wrong]
        determined = np.all(sigma < OBSERVABLE * np.abs(other.value[wrong]))
        if determined and explains(rows, other.value, other.beta, prior):
            return other
    return _held(rows, value) if wrong or pulled else value


def _away(value: Estimate, prior: Prior) -> Vector:
    """Differences from what was known beforehand, in their sigma, (P,)."""
    spread = np.diagonal(value.covariance) + 1.0 / np.maximum(prior.precision, 1e-300)
    return np.abs(value.value - prior.mean) / np.sqrt(spread)


def _contradicts(value: Estimate, prior: Prior) -> bool:
    """Whether an estimate without what was known beforehand clearly contradicts it."""
    places = stated(value.value.size)
    return value.prior is not prior and bool(np.any(_away(value, prior)[places] > APART))


def _worse(value: Estimate, held: list[int]) -> list[int]:
    """Further parameters that agree with what was known beforehand, and are known less well."""
    worse = np.diagonal(value.covariance) * value.prior.precision > LOST
    worse &= _away(value, value.prior) < AGREEING
    return [place for place in np.flatnonzero(worse).tolist() if place not in held]


def _as_stated(
    rows: Rows, value: Estimate, places: list[int], errors_of: Callable[[Estimate], Matrix]
) -> Estimate:
    """Estimate with some parameters, and their errors, as known beforehand."""
    other = _with_held(rows, value, places)
    moves = other.prior.precision[places] / np.sqrt(value.prior.precision[places])
    moved, mean_moved = other.covariance[:, places] * moves, other.mean_covariance[places] * moves
    wide = widened(rows, other, errors_of(other)).with_errors(moved, mean_moved, lasting=True)
    return replace(wide, prior=value.prior, held=tuple(places))


def _with_held(rows: Rows, value: Estimate, places: list[int]) -> Estimate:
    """Estimate with some parameters as known beforehand, without an error."""
    held = value.prior.held(places)
    return estimate(rows, held, held.mean.copy(), value.noise, believe=True)


def _apart(value: Estimate, prior: Prior) -> tuple[list[int], bool]:
    """Stated parameters that data contradict; whether others move by more than data know of them.

    Args:
        value: Estimate.
        prior: What was known beforehand.
    """
    wrong, pulled = [], False
    for place in stated(value.value.size):
        variance, precision = value.covariance[place, place], prior.precision[place]
        away = abs(value.value[place] - prior.mean[place])
        # the variance of the difference between the prior and an estimate that contains it
        spread = max(1.0 / precision - variance, 0.0)
        # weak data may differ by much in their own sigma, by nothing that counts
        told = spread > TOLD / precision and away > APART * np.sqrt(spread)
        # by rounding, they may know less than what was known
        if told or away > APART * np.sqrt(max(1.0 / precision, variance)):
            wrong.append(place)
        elif away > max(APART * np.sqrt(spread), 1.0 / np.sqrt(precision)):
            pulled = True
    if abs(value.value[LAG]) > LATE / np.sqrt(prior.precision[LAG]):
        wrong.append(LAG)
    return wrong, pulled


def _held(rows: Rows, value: Estimate) -> Estimate:
    """Estimate with all stated parameters as stated, with the difference this makes as an error.

    Data that move a parameter by more than they can know of it have other noise than assumed.

    Args:
        rows: Rows of the regression.
        value: Estimate in which they are not held.
    """
    other = _with_held(rows, value, stated(value.value.size))
    other = replace(
        other,
        covariance=value.covariance,
        scatter=value.scatter,
        mean_covariance=value.mean_covariance,
        mean_variance=value.mean_variance,
        mean_scatter=value.mean_scatter,
        prior=value.prior,
    )
    away = (value.value - other.value)[:, None]
    return other.with_errors(away, np.array([value.mean - other.mean]))
