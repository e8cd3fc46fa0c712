"""Worst case of two-wheel pointing over the dispersions of `two_wheels.py`, by a search.

    python benchmarks/two_wheels_worst.py [--runs 128] [--generations 12] [--seed 2] [--gyroless]

A point of the unit box gives every number that `two_wheels.drawn` draws. Differential evolution,
with a batch as generation, looks for the latest case, for the largest torque demand, and for the
largest error at the end. Half of the first generation are corners. The noise of a run belongs to
its place in the batch. Seeds below 1000 served development.
"""

import argparse
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.special import ndtri
from two_wheels import allowed, arguments, drawn, flown

from gyrostat.papers.endo_sekiguchi_nonaka.controllers import Outcome
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import Case

MARGIN = 1e-3
"""Least distance of a coordinate from 0 and 1: the normal distribution has no end."""


class Point:
    """Stands for a random generator: its numbers are the coordinates of a point, in order."""

    def __init__(self, coordinates: np.ndarray):
        self.rest = list(coordinates)

    def _next(self, size: int | None) -> Any:
        count = 1 if size is None else size
        taken, self.rest = np.array(self.rest[:count]), self.rest[count:]
        return taken[0] if size is None else taken

    def uniform(self, low: float, high: float, size: int | None = None) -> Any:
        return low + (high - low) * self._next(size)

    def normal(self, *, size: int) -> Any:
        return ndtri(self._next(size))

    def choice(self, options: Any, size: int | None = None) -> Any:
        return np.asarray(options)[np.int_(self._next(size) * len(options))]


NAMES: dict[str, Callable[[list[Case], Outcome], np.ndarray]] = {
    "late by, s": lambda cases, found: found.settled - allowed(cases),
    "torque demand, N·m": lambda cases, found: found.demand,
    "error at the end, deg": lambda cases, found: found.last,
}
"""What is searched for -> its value in each case."""


def worst(given: argparse.Namespace, value: Callable[..., np.ndarray]) -> tuple[float, Case]:
    """Largest value found, and its case (current-to-best/1/bin)."""

    def tried(points: np.ndarray) -> tuple[np.ndarray, list[Case]]:
        cases = [drawn(Point(point)) for point in points]
        return value(cases, flown(cases, given)), cases

    random = np.random.default_rng(given.seed)
    points = random.uniform(MARGIN, 1.0 - MARGIN, (given.runs, DIMENSIONS))
    points[::2] = np.where(points[::2] < 0.5, MARGIN, 1.0 - MARGIN)
    found, cases = tried(points)
    for _ in range(given.generations):
        first, second = (points[random.permutation(given.runs)] for _ in range(2))
        mutant = points + 0.45 * (points[np.argmax(found)] - points) + 0.6 * (first - second)
        trial = np.where(random.uniform(size=points.shape) < 0.8, mutant, points)
        trial = np.clip(trial, MARGIN, 1.0 - MARGIN)
        values, own = tried(trial)
        better = values > found
        points = np.where(better[:, None], trial, points)
        cases = [b if take else a for take, a, b in zip(better, cases, own, strict=True)]
        found = np.maximum(found, values)
    k = int(np.argmax(found))
    return float(found[k]), cases[k]


def main() -> None:
    """Print the worst of each value."""
    given = arguments(__doc__, runs=128, generations=12, seed=2)
    for name, value in NAMES.items():
        found, case = worst(given, value)
        print(f"{name}: {found:.4f}, from {np.degrees(case.angle):.1f} deg", flush=True)


DIMENSIONS = 64
drawn(counted := Point(np.full(DIMENSIONS, 0.5 + MARGIN)))
DIMENSIONS -= len(counted.rest)

if __name__ == "__main__":
    main()
