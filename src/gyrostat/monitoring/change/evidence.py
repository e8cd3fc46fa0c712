"""Evidence for each class of change: marginal likelihood against a healthy wheel.

The sizes of a fault are Gaussian, so that the marginal likelihood of a fault with a given onset is
a closed form of the sums of `Levels`. It is summed over onsets and averaged over courses and
alternative sizes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.classes_of import classes_of
from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.change import kinds
from gyrostat.monitoring.change.kinds.change_kind import ChangeKind
from gyrostat.monitoring.change.levels import COURSES, Levels

KINDS: tuple[type[ChangeKind], ...] = classes_of(kinds, ChangeKind)
"""Classes of change."""
NAMES = tuple(kind.name for kind in KINDS)
SIGNATURES = np.unique(np.stack([s for kind in KINDS for s in kind.signatures]), axis=0)
"""All signatures, each once, (K, 8)."""
_PLACES = tuple(
    tuple(int(np.flatnonzero(np.all(s == SIGNATURES, axis=1))[0]) for s in kind.signatures)
    for kind in KINDS
)


def log_marginal(
    information: NDArray[np.float64],
    score: NDArray[np.float64],
    sizes: Vector,
    means: Sequence[float] = (0.0, 0.0),
) -> NDArray[np.float64]:
    """Log of E[exp(b' x - x' A x / 2)] for independent Gaussian sizes x.

    Args:
        information: A, (n, n, ...), n of 1 or 2.
        score: b, (n, ...).
        sizes: Standard deviations of x, (n,).
        means: Means of x, (n,).
    """
    mean = np.asarray(means, dtype=float)[: len(sizes)]
    if np.any(mean):
        # x = mean + y, y with mean 0
        response = np.tensordot(mean, information, axes=(0, 0))
        constant = np.tensordot(mean, score - 0.5 * response, axes=(0, 0))
        return constant + log_marginal(information, score - response, sizes)
    variance = np.asarray(sizes, dtype=float) ** 2
    if len(variance) == 1:
        inner = 1.0 + variance[0] * information[0, 0]
        return 0.5 * variance[0] * score[0] ** 2 / inner - 0.5 * np.log(inner)
    (first, cross), (_, second) = information
    v, w = variance
    inner = (1.0 + v * first) * (1.0 + w * second) - v * w * cross**2
    square = (
        v * (1.0 + w * second) * score[0] ** 2
        - 2.0 * v * w * cross * score[0] * score[1]
        + w * (1.0 + v * first) * score[1] ** 2
    )
    return 0.5 * square / inner - 0.5 * np.log(inner)


@dataclass(frozen=True, eq=False)
class Evidence:
    """Evidence after a window.

    Attributes:
        onset: Log of the marginal likelihood ratio of each class and onset, (classes, onsets); -inf
            where there is no such onset.
        began: Window of each onset, (onsets,).
    """

    onset: Matrix
    began: Vector

    def total(self) -> Vector:
        """Log of the sum over onsets for each class, (classes,)."""
        return np.logaddexp.reduce(self.onset, axis=1)

    def statistic(self, rates: Vector) -> float:
        """Log of the Shiryaev-Roberts statistic with the classes in proportion to their rates.

        Args:
            rates: Rate of each class, (classes,).
        """
        share = np.log(rates) - np.log(np.sum(rates))
        return float(np.logaddexp.reduce(share + self.total()))

    def probabilities(self, rates: Vector) -> Vector:
        """Probability of no change and of each class, (1 + classes,).

        Args:
            rates: Rate of each class per window, (classes,).
        """
        logs = np.concatenate([[0.0], np.log(rates) + self.total()])
        return np.exp(logs - np.logaddexp.reduce(logs))

    def onset_probabilities(self, kind: int) -> Vector:
        """Probability of each onset, given the class, (onsets,)."""
        logs = self.onset[kind]
        return np.exp(logs - np.logaddexp.reduce(logs))


def evidence(levels: Levels) -> Evidence:
    """Evidence from the sums of the levels.

    Args:
        levels: Levels with `SIGNATURES`.
    """
    rows = [_class_evidence(levels, k) for k in range(len(KINDS))]
    onset = np.where(levels.began >= 0.0, np.stack(rows), -np.inf)
    return Evidence(onset, levels.began.copy())


@dataclass(frozen=True, eq=False)
class Changed:
    """Most probable change of a class.

    Attributes:
        state: State of a healthy wheel without the change; see `Levels.mean`, (10,).
        change: What the change adds to each channel now, (8,).
        sizes: Sizes of the signatures.
    """

    state: Vector
    change: Vector
    sizes: Vector


def changed(levels: Levels, k: int) -> Changed:
    """Most probable change of a class: its onset, course and sizes.

    Args:
        levels: Levels with `SIGNATURES`.
        k: Index of the class.
    """
    places, logs = list(_PLACES[k]), _class_logs(levels, k)
    logs = np.where((levels.began >= 0.0)[:, None], logs, -np.inf)
    onset, alternative = np.unravel_index(int(np.argmax(logs)), logs.shape)
    courses = len(COURSES) if KINDS[k].ramps else 1
    alternative, course = divmod(int(alternative), courses)
    information = levels.information[np.ix_(places, places)][..., onset, course]
    prior = np.diag(1.0 / np.array(KINDS[k].sizes[alternative]) ** 2)
    means = np.array(KINDS[k].means[: len(places)])
    score = levels.score[places, onset, course] + prior @ means
    sizes = np.asarray(np.linalg.solve(information + prior, score), dtype=float)
    return Changed(
        levels.mean - sizes @ levels.response[places, onset, course],
        # the last window is the one before `count`
        levels.courses(-1)[onset, course] * sizes @ SIGNATURES[places],
        sizes,
    )


def _class_evidence(levels: Levels, k: int) -> Vector:
    logs = _class_logs(levels, k)
    return np.logaddexp.reduce(logs, axis=1) - np.log(logs.shape[1])


def _class_logs(levels: Levels, k: int) -> Matrix:
    """Log of the likelihood ratio of each onset, and of each size and course, (onsets, ...)."""
    kind, places = KINDS[k], _PLACES[k]
    courses = len(COURSES) if kind.ramps else 1
    information = levels.information[np.ix_(places, places)][..., :courses]
    score = levels.score[list(places)][..., :courses]
    logs = [log_marginal(information, score, np.array(sizes), kind.means) for sizes in kind.sizes]
    return np.concatenate(logs, axis=1)
