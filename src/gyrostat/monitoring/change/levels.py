"""Levels of a healthy wheel, and how unit faults of each onset would show in their innovations.

A Kalman filter follows the levels of all channels, which are random walks, and the temperature
coefficients of Coulomb torque and viscous friction. A fault of unit size, begun at a window s with
a given course, adds a known sequence to the innovations, which is the response of the same filter
(A. S. Willsky, H. L. Jones, "A generalized likelihood ratio approach to the detection and
estimation of jumps in linear systems", IEEE Trans. Automatic Control 21, 1976). With it, the
likelihood of a fault against none has the exponent b beta - a beta²/2 in its size beta, where a and
b are sums over the windows since s.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.change.channels import (
    CHANNELS,
    PRIOR_SIGMA,
    STATED,
    Observation,
    Reference,
)

STATES = len(CHANNELS) + 2
"""Levels, then the temperature coefficients of Coulomb and viscous friction."""
WIDEST = np.array([25.0, 4.0, 0.01, 0.25])
"""Largest variances of the levels beforehand: a nominal Coulomb torque may be wrong by a factor."""
RAMP = 30.0
"""Duration of a ramp, and the time over which an endless ramp grows by one, windows."""
COURSES = ("step", "ramp", "endless")
LARGEST = 16.0
"""Squared innovation per channel, in its variance, beyond which a window counts less."""


@dataclass(frozen=True)
class LevelSettings:
    """Prior of the levels.

    Attributes:
        walk: Random walk of each relative channel, per square root of a window.
        extra_walk: Random walk of the other channels, in their standard deviations.
        memory: Windows with the weight of which the variances are known beforehand.
        onsets: Number of windows before the present in which a change may have begun.
    """

    walk: float = 2e-4
    extra_walk: float = 0.01
    memory: float = 20.0
    onsets: int = 150


@dataclass(eq=False)
class Levels:
    """State of the filter of one wheel; `update` takes one window.

    Attributes:
        signatures: Signatures whose responses are followed, (K, 8).
        settings: Settings.
        reference: What is known beforehand.
        count: Number of windows so far.
        mean: State, (10,).
        covariance: (10, 10).
        scatter: Factors of the stated variances of the estimates, together, and of each other
            channel, learnt, (5,).
        weight: Number of values that each of `scatter` rests on, (5,).
        response: Response of the state to each unit fault, (K, onsets, courses, 10).
        information: a of each pair of signatures, (K, K, onsets, courses).
        score: b, (K, onsets, courses).
        began: Window of each onset, (onsets,); -1: none.
    """

    signatures: Matrix
    settings: LevelSettings = field(default_factory=LevelSettings)
    reference: Reference = field(default_factory=lambda: Reference(1.0, 1.0, 1.0))
    count: int = 0
    mean: Vector = field(init=False)
    covariance: Matrix = field(init=False)
    scatter: Vector = field(init=False)
    weight: Vector = field(init=False)
    response: Matrix = field(init=False)
    information: Matrix = field(init=False)
    score: Matrix = field(init=False)
    began: Vector = field(init=False)

    def __post_init__(self):
        kinds, onsets, courses = len(self.signatures), self.settings.onsets, len(COURSES)
        mean, precision = self.reference.prior()
        self.mean = np.zeros(STATES)
        self.mean[:STATED] = [*mean, 1.0]
        known = np.minimum(1.0 / np.maximum(precision, 1e-12), WIDEST)
        self.covariance = np.diag([*known, 1.0, 25.0, 1.0, 1.0, 1e-5, 1e-3])
        self.scatter = np.concatenate([[1.0], PRIOR_SIGMA**2])
        self.weight = np.array([self.settings.memory, 5.0, 5.0, 5.0, 5.0])
        self.response = np.zeros((kinds, onsets, courses, STATES))
        self.information = np.zeros((kinds, kinds, onsets, courses))
        self.score = np.zeros((kinds, onsets, courses))
        self.began = np.full(onsets, -1.0)

    def courses(self, later: int = 0) -> Matrix:
        """Course of a unit fault at the middle of a window, (onsets, courses).

        Args:
            later: Number of the window, from the one that `update` takes next.
        """
        age = self.count + later - self.began + 0.5
        rise = age / RAMP
        return np.stack([np.ones_like(age), np.minimum(rise, 1.0), rise], axis=1)

    def update(self, seen: Observation) -> float:
        """Take the next window.

        Returns:
            Squared innovation per channel, in its variance; NaN if the window has no channel.
        """
        slot = self.count % self.settings.onsets
        self.began[slot] = self.count
        self.response[:, slot] = 0.0
        self.information[:, :, slot] = 0.0
        self.score[:, slot] = 0.0
        self._walk()
        size = self._correct(seen) if seen.value.size else np.nan
        self.count += 1
        return size

    def _walk(self) -> None:
        walk = np.zeros(STATES)
        walk[:STATED] = self.settings.walk**2
        walk[STATED : len(CHANNELS)] = self.settings.extra_walk**2 * self.scatter[2:]
        self.covariance[np.diag_indices(STATES)] += walk

    def _observed(self, seen: Observation) -> tuple[Matrix, Matrix]:
        matrix = np.zeros((seen.value.size, STATES))
        matrix[:, : len(CHANNELS)] = seen.direction
        matrix[:, len(CHANNELS) :] = seen.temperature * seen.direction[:, :2]
        return matrix, np.diag(self.scatter[self._factors(seen)] * seen.variance)

    def _factors(self, seen: Observation) -> NDArray[np.int64]:
        """Place in `scatter` of each value, (M,)."""
        estimates = seen.value.size - len(seen.extras)
        return np.array([0] * estimates + [1 + extra for extra in seen.extras], dtype=np.int64)

    def _correct(self, seen: Observation) -> float:
        matrix, noise = self._observed(seen)
        innovation = seen.value - matrix @ self.mean
        spread = matrix @ self.covariance @ matrix.T + noise
        size = float(innovation @ np.linalg.solve(spread, innovation)) / innovation.size
        if size > LARGEST:
            spread = spread * (size / LARGEST)
        inverse = np.linalg.inv(spread)
        self._learn(seen, innovation, spread)
        gain = self.covariance @ matrix.T @ inverse
        fault = (self.signatures @ seen.direction.T)[:, None, None, :]
        fault = fault * self.courses()[None, :, :, None]
        missed = fault - self.response @ matrix.T
        whitened = missed @ inverse
        self.score += whitened @ innovation
        self.information += np.einsum("jocm,kocm->jkoc", missed, whitened)
        self.response += missed @ gain.T
        self.mean = self.mean + gain @ innovation
        left = np.eye(STATES) - gain @ matrix
        self.covariance = left @ self.covariance @ left.T + gain @ noise @ gain.T
        return size

    def _learn(self, seen: Observation, innovation: Vector, spread: Matrix) -> None:
        """Learn the variances from innovations, each limited to three standard deviations."""
        count = seen.value.size - len(seen.extras)
        if count:
            block = spread[:count, :count]
            size = innovation[:count] @ np.linalg.solve(block, innovation[:count])
            self._blend(0, min(size / count, 9.0) * self.scatter[0], float(count))
        for k, extra in enumerate(seen.extras):
            ratio = min(innovation[count + k] ** 2 / spread[count + k, count + k], 9.0)
            self._blend(1 + extra, ratio * self.scatter[1 + extra], 1.0)

    def _blend(self, at: int, value: float, count: float) -> None:
        # a year of windows at most, so that a long history does not freeze it
        self.weight[at] = min(self.weight[at] + count, max(400.0, self.settings.memory))
        self.scatter[at] += (value - self.scatter[at]) * count / self.weight[at]
