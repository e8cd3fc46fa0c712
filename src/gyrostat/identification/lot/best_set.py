"""Best wheels of a lot for one spacecraft, with the probability that they are the best.

A criterion is a rule and a parameter: "lowest" or "highest" is the sum of the parameter over the
set, "matched" its variance in the set. A matched set is without gaps in the sorted order: a gap's
wheel in place of the outermost one would reduce the variance. Therefore both are found exactly.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.pictured import Described
from gyrostat.core.skewed_normal import value_at
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.lot.likelihood import SCORES, SHARES

Places = NDArray[np.intp]
"""Indices of wheels."""
RULES = ("lowest", "highest", "matched")
DRAWS = 4000
CANDIDATES = 200
"""Sets that are best in the most draws; one of them is chosen."""
SEED = 20260102


@dataclass(frozen=True)
class BestSet(Described):
    """Best set of wheels by a criterion.

    Attributes:
        rule: One of `RULES`.
        parameter: Name of the parameter.
        wheels: Indices of the wheels.
        probability: Probability that no other set is better.
        each: Probability of each wheel of the set to be in the best one.
        excess: Mean of the criterion beyond that of the best set: of the mean of the parameter, or
            of its standard deviation in the set, SI.
    """

    rule: str
    parameter: str
    wheels: tuple[int, ...]
    probability: float
    each: tuple[float, ...]
    excess: float


def true_values(
    values: Vector, errors: Vector, lot: tuple[float, float, float], random: np.random.Generator
) -> Matrix:
    """Draws of the true parameter of each wheel, (draws, n), from its estimate and the lot.

    Args:
        values: Estimates, (n,).
        errors: Standard deviations of their errors, (n,).
        lot: Location, scale and shape of the lot.
        random: Source of random numbers.
    """
    location, scale, shape = lot
    draws = np.empty((DRAWS, len(values)))
    for k, (value, error) in enumerate(zip(values, errors, strict=True)):
        # numbers about the most likely one, at which the integrand is not negligible
        coarse = value_at(SCORES, location, scale, shape)
        height = np.log(SHARES) - 0.5 * ((value - coarse) / error) ** 2
        near = SCORES[height > height.max() - 40.0]
        step = SCORES[1] - SCORES[0]
        score = np.linspace(near[0] - step, near[-1] + step, 2001)
        x = value_at(score, location, scale, shape)
        exponent = -0.5 * score**2 - 0.5 * ((value - x) / error) ** 2
        share = np.cumsum(np.exp(exponent - exponent.max()))
        draws[:, k] = np.interp(random.random(DRAWS) * share[-1], share, x)
    return draws


def best_set(rule: str, parameter: str, draws: Matrix, size: int) -> BestSet:
    """Best set of wheels.

    Args:
        rule: One of `RULES`.
        parameter: Name of the parameter.
        draws: Draws of the true parameter of each wheel, (draws, n).
        size: Number of wheels of the set, less than n.
    """
    sets = np.sort(_best(rule, draws, size), axis=1)
    estimate = _chosen(rule, draws, sets)
    probability = float(np.mean(np.all(sets == estimate, axis=1)))
    each = tuple(float(np.mean(np.any(sets == wheel, axis=1))) for wheel in estimate)
    rows = np.arange(len(draws))[:, None]
    cost = _cost(rule, draws[:, estimate]) - _cost(rule, draws[rows, sets])
    wheels = tuple(int(wheel) for wheel in estimate)
    return BestSet(rule, parameter, wheels, probability, each, float(np.mean(cost)))


def _cost(rule: str, values: Matrix) -> Vector:
    """Criterion of sets, (draws, size), to be minimised."""
    if rule == "matched":
        return np.std(values, axis=-1)
    return np.mean(values, axis=-1) * (1.0 if rule == "lowest" else -1.0)


def _chosen(rule: str, draws: Matrix, sets: Places) -> Places:
    """Set with the least mean of sum or variance, sorted, (size,).

    The mean of the variance of a set is that of its means, plus the mean variance of its wheels.

    Args:
        rule: One of `RULES`.
        draws: Draws of the true parameter of each wheel, (draws, n).
        sets: Best set of each draw, sorted, (draws, size).
    """
    of_means = _best(rule, draws.mean(axis=0)[None], sets.shape[1])
    if rule != "matched":
        return np.sort(of_means[0])
    unique, counts = np.unique(sets, axis=0, return_counts=True)
    frequent = unique[np.argsort(-counts, kind="stable")[:CANDIDATES]]
    candidates = np.vstack([frequent, of_means])
    means = [np.mean(np.var(draws[:, wheels], axis=1)) for wheels in candidates]
    return np.sort(candidates[int(np.argmin(means))])


def _best(rule: str, draws: Matrix, size: int) -> Places:
    """Best set of each row of values, (draws, size), in no order."""
    if rule != "matched":
        signed = draws if rule == "lowest" else -draws
        return np.argpartition(signed, size - 1, axis=1)[:, :size]
    order = np.argsort(draws, axis=1)
    ordered = np.take_along_axis(draws, order, axis=1)
    windows = np.lib.stride_tricks.sliding_window_view(ordered, size, axis=1)
    start = np.argmin(windows.var(axis=-1), axis=1)
    return np.take_along_axis(order, start[:, None] + np.arange(size), axis=1)
