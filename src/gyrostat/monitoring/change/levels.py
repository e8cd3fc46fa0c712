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
from gyrostat.monitoring.change.channels import CHANNELS, PRIOR_SIGMA, Observation

STATES = len(CHANNELS) + 2
"""Levels, then the temperature coefficients of Coulomb and viscous friction."""
MOTOR_CONSTANT = CHANNELS.index("motor_constant")
RAMP = 30.0
"""Duration of a ramp, and the time over which an endless ramp grows by one, windows."""
COURSES = ("step", "ramp", "endless")
LARGEST = 16.0
"""Squared innovation per channel, in its variance, beyond which a window counts less."""


@dataclass(frozen=True)
class LevelSettings:
    """Prior of the levels.

    Attributes:
        walk: Random walk of each of the four estimates, relative, per square root of a window.
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
        signatures: Signatures whose responses are followed, in windows that determine the motor
            constant and in others, (2, K, 8).
        settings: Prior.
        count: Number of windows so far.
        mean: State, (10,).
        covariance: (10, 10).
        scatter: Factor of the estimates' variance, learnt; and the variances of the other channels,
            (5,).
        weight: Number of values that each of `scatter` rests on, (5,).
        response: Response of the state to each unit fault, (K, onsets, courses, 10).
        information: a of each pair of signatures, (K, K, onsets, courses).
        score: b, (K, onsets, courses).
        began: Window of each onset, (onsets,); -1: none.
    """

    signatures: Matrix
    settings: LevelSettings = field(default_factory=LevelSettings)
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
        kinds, onsets, courses = self.signatures.shape[1], self.settings.onsets, len(COURSES)
        self.mean = np.zeros(STATES)
        self.mean[:3] = 1.0
        self.covariance = np.diag([1.0, 1.0, 0.01, 0.25, 25.0, 1.0, 25.0, 0.01, 1e-5, 1e-3])
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
        present = np.flatnonzero(np.isfinite(seen.value))
        size = self._correct(seen, present) if present.size else np.nan
        self.count += 1
        return size

    def _walk(self) -> None:
        walk = np.zeros(STATES)
        walk[:4] = self.settings.walk**2
        walk[4:8] = self.settings.extra_walk**2 * self.scatter[1:]
        self.covariance[np.diag_indices(STATES)] += walk

    def _observed(self, seen: Observation, present: NDArray[np.intp]) -> tuple[Matrix, Matrix]:
        matrix = np.zeros((len(CHANNELS), STATES))
        matrix[:, : len(CHANNELS)] = np.eye(len(CHANNELS))
        matrix[0, 8] = matrix[1, 9] = seen.temperature
        noise = np.diag(np.concatenate([np.zeros(4), self.scatter[1:]]))
        noise[:4, :4] = self.scatter[0] * seen.covariance
        return matrix[present], noise[np.ix_(present, present)]

    def _correct(self, seen: Observation, present: NDArray[np.intp]) -> float:
        matrix, noise = self._observed(seen, present)
        innovation = seen.value[present] - matrix @ self.mean
        spread = matrix @ self.covariance @ matrix.T + noise
        size = float(innovation @ np.linalg.solve(spread, innovation)) / present.size
        if size > LARGEST:
            spread = spread * (size / LARGEST)
        inverse = np.linalg.inv(spread)
        self._learn(present, innovation, spread)
        gain = self.covariance @ matrix.T @ inverse
        signatures = self.signatures[0 if MOTOR_CONSTANT in present else 1]
        fault = signatures[:, None, None, present] * self.courses()[None, :, :, None]
        missed = fault - self.response @ matrix.T
        whitened = missed @ inverse
        self.score += whitened @ innovation
        self.information += np.einsum("jocm,kocm->jkoc", missed, whitened)
        self.response += missed @ gain.T
        self.mean = self.mean + gain @ innovation
        left = np.eye(STATES) - gain @ matrix
        self.covariance = left @ self.covariance @ left.T + gain @ noise @ gain.T
        return size

    def _learn(self, present: NDArray[np.intp], innovation: Vector, spread: Matrix) -> None:
        """Learn the variances from innovations, each limited to three standard deviations."""
        linear = present < 4
        if np.any(linear):
            block = spread[np.ix_(linear, linear)]
            size = innovation[linear] @ np.linalg.solve(block, innovation[linear])
            count = float(np.sum(linear))
            self._blend(0, min(size / count, 9.0) * self.scatter[0], count)
        for k in np.flatnonzero(~linear):
            at = int(present[k]) - 3
            ratio = min(innovation[k] ** 2 / spread[k, k], 9.0)
            self._blend(at, ratio * self.scatter[at], 1.0)

    def _blend(self, at: int, value: float, count: float) -> None:
        # a year of windows at most, so that a long history does not freeze it
        self.weight[at] = min(self.weight[at] + count, max(400.0, self.settings.memory))
        self.scatter[at] += (value - self.scatter[at]) * count / self.weight[at]
