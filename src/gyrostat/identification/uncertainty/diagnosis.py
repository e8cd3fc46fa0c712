"""Diagnosis of a fit: find the effects that explain its residuals, by score tests.

All candidates are linear in their coefficients at the fit. One Kalman filter has whitened their
columns for every level of random torque (`gyrostat.identification.uncertainty.innovations`). The
deviance of any combination is then a small linear problem, and no fit is repeated (Rao 1948, score
test).
Effects are added one by one while the best one is significant over all candidates (Bonferroni).
Effects that are no longer significant are removed at the end. An effect that explains the
residuals nearly as well as one that was found cannot be distinguished from it: both are reported
together.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.findings import Finding, Score, by_evidence
from gyrostat.identification.read.statistics import chi_square_tail
from gyrostat.identification.uncertainty.effects import CONSTANT_TORQUE, Nuisance
from gyrostat.identification.uncertainty.hypotheses import summed
from gyrostat.identification.uncertainty.innovations import Innovations

FALSE_ALARMS = 0.04
"""False-alarm rate: fraction of records without effects in which one is found (Bonferroni)."""
INDISTINGUISHABLE = 6.0
"""Difference of the BIC below which two effects are reported together (Kass and Raftery 1995:
above it the evidence is strong)."""
CATCH_ALL = 0.7
"""Factor on the evidence of a random torque in comparisons with deterministic effects. It can
follow any of them, and a strong, slightly nonlinear one better than the effect's own column can."""
MOST_EFFECTS = 6
"""Largest number of effects."""
ALIEN = 1e-6
"""Smallest fraction of a candidate's whitened column that is independent of the parameters'
columns; below it the record cannot show the effect."""

TORQUES = (
    ("crossing_ripple", "torque ripple near zero speed, fraction of the dry friction"),
    ("torque_walk", "random-walk torque over the record, fraction of the dry friction"),
)
"""Random torques, in the order of the levels."""


class _Problem:
    """Deviance of any set of effects at any level of random torque."""

    def __init__(
        self,
        innovations: Sequence[Innovations],
        levels: Matrix,
        effects: Sequence[Nuisance],
        prior: tuple[Matrix, Vector],
        stated: bool,
    ) -> None:
        self.levels, self.effects = levels, effects
        self.information, self.pull = prior
        self.count = len(self.pull)
        self.samples = sum(record.samples for record in innovations)
        self.total, self.logs = summed(innovations, stated)
        ends = self.count + np.cumsum([0, *(e.columns[0].shape[1] for e in effects)])
        self.places = [range(a, b) for a, b in pairwise(ends.tolist())]

    def solve(self, level: int, chosen: Sequence[int]) -> tuple[float, Vector, Matrix]:
        """Deviance, coefficients of parameters and chosen effects, and their covariance."""
        columns = [*range(self.count), *(p for k in chosen for p in self.places[k])]
        rows = 1 + np.array(columns)
        matrix = self.total[level][np.ix_(rows, rows)].copy()
        right = self.total[level][rows, 0].copy()
        matrix[: self.count, : self.count] += self.information
        right[: self.count] += self.pull
        unit = np.sqrt(np.maximum(np.diag(matrix), np.finfo(float).tiny))
        inverse = np.linalg.pinv(matrix / np.outer(unit, unit), rcond=1e-12, hermitian=True)
        inverse /= np.outer(unit, unit)
        solution = inverse @ right
        deviance = self.logs[level] + self.total[level][0, 0] - float(right @ solution)
        return float(deviance), solution, inverse

    def visible(self, effect: int) -> bool:
        """Whether an effect's columns are not a linear combination of the parameters' columns."""
        rows = 1 + np.arange(self.count)
        matrix = self.total[0][np.ix_(rows, rows)] + self.information
        for index in self.places[effect]:
            cross, power = self.total[0][rows, 1 + index], self.total[0][1 + index, 1 + index]
            residual = power - float(cross @ np.linalg.lstsq(matrix, cross, rcond=1e-12)[0])
            if power > 0.0 and residual > ALIEN * power:
                return True
        return False

    def along(self, level: int, axis: int, *, present: bool) -> list[int]:
        """Levels that differ from the given one at most in one random torque, present or absent."""
        other_axis = 1 - axis
        matches = self.levels[:, other_axis] == self.levels[level, other_axis]
        return np.flatnonzero(matches & ((self.levels[:, axis] > 0.0) == present)).tolist()


@dataclass(frozen=True)
class _State:
    """Deterministic effects and the level of random torque included so far."""

    level: int
    chosen: tuple[int, ...] = ()


_Key = tuple[str, int]


def _keys(problem: _Problem) -> list[_Key]:
    """All candidates: deterministic effects that the record can show, and random torques."""
    shapes = [
        ("shape", k)
        for k, effect in enumerate(problem.effects)
        if effect.name != CONSTANT_TORQUE and problem.visible(k)
    ]
    return [*shapes, ("torque", 0), ("torque", 1)]


def _is_present(problem: _Problem, state: _State, key: _Key) -> bool:
    kind, index = key
    return index in state.chosen if kind == "shape" else problem.levels[state.level, index] > 0.0


def _add(problem: _Problem, state: _State, key: _Key) -> _State:
    """State with a candidate added; a random torque at its best level."""
    kind, index = key
    if kind == "shape":
        return _State(state.level, (*state.chosen, index))
    levels = problem.along(state.level, index, present=True)
    return _State(min(levels, key=lambda k: problem.solve(k, state.chosen)[0]), state.chosen)


def _remove(problem: _Problem, state: _State, key: _Key) -> _State:
    kind, index = key
    if kind == "shape":
        return _State(state.level, tuple(k for k in state.chosen if k != index))
    return _State(problem.along(state.level, index, present=False)[0], state.chosen)


def _gain(problem: _Problem, before: _State, after: _State, key: _Key) -> tuple[float, float]:
    """Decrease of the BIC, and the probability of so large a decrease by chance."""
    fall = problem.solve(before.level, before.chosen)[0]
    fall -= problem.solve(after.level, after.chosen)[0]
    kind, index = key
    freedom = len(problem.places[index]) if kind == "shape" else 1
    chance = chi_square_tail(fall, freedom)
    # levels are nonnegative: in half of the records without random torque the estimate is zero
    return fall - freedom * math.log(problem.samples), 0.5 * chance if kind == "torque" else chance


def _rank(gain: float, key: _Key) -> float:
    """Decrease of the BIC for ranking, penalised for random torques, which mimic all others."""
    return CATCH_ALL * gain if key[0] == "torque" and gain > 0.0 else gain


def _select(problem: _Problem, keys: Sequence[_Key]) -> _State:
    """Add effects, best first, and remove those that are no longer significant."""
    limit = FALSE_ALARMS / len(keys)
    state = _State(int(np.flatnonzero(~problem.levels.any(axis=1))[0]))
    for _ in range(MOST_EFFECTS):
        trials = []
        for key in keys:
            if not _is_present(problem, state, key):
                after = _add(problem, state, key)
                gain, chance = _gain(problem, state, after, key)
                if chance < limit:
                    trials.append((_rank(gain, key), after))
        if not trials:
            break
        state = max(trials, key=lambda trial: trial[0])[1]
    for key in keys:
        if _is_present(problem, state, key):
            before = _remove(problem, state, key)
            if _gain(problem, before, state, key)[1] >= limit:
                state = before
    return state


def _describe(
    problem: _Problem, state: _State, key: _Key, keys: Sequence[_Key], names, scale
) -> Finding:
    """Finding for an effect: size, evidence, consequences and equivalent effects."""
    before = _remove(problem, state, key)
    evidence, _ = _gain(problem, before, state, key)
    candidates = [(_rank(evidence, key), evidence, key)]
    for alternative in keys:
        if not _is_present(problem, state, alternative):
            gain, chance = _gain(problem, before, _add(problem, before, alternative), alternative)
            alike = abs(evidence - gain) < INDISTINGUISHABLE
            if alike and chance < FALSE_ALARMS / len(keys):
                candidates.append((_rank(gain, alternative), gain, alternative))
    candidates.sort(key=lambda row: -row[0])
    _, evidence, first = candidates[0]
    after = _add(problem, before, first)
    deviance, solution, covariance = problem.solve(after.level, after.chosen)
    bare, plain, _ = problem.solve(before.level, before.chosen)
    kind, index = first
    if kind == "shape":
        size = solution[-len(problem.places[index]) :]
        largest = int(np.argmax(np.abs(size))) - len(size)
        value, sigma = float(solution[largest]), float(np.sqrt(covariance[largest, largest]))
        unit = problem.effects[index].unit
    else:
        value, sigma, unit = float(problem.levels[after.level, index]), None, "1"
    shift = scale * (solution[: problem.count] - plain[: problem.count])
    labels = [
        (problem.effects[k].name, problem.effects[k].title) if kind == "shape" else TORQUES[k]
        for *_, (kind, k) in candidates
    ]
    return Finding(
        names=tuple(name for name, _ in labels),
        titles=tuple(title for _, title in labels),
        value=value,
        sigma=sigma,
        unit=unit,
        significance=float(np.sqrt(max(bare - deviance, 0.0))),
        evidence=evidence,
        shifts=dict(zip(names, shift.tolist(), strict=True)),
    )


def _scores(problem: _Problem, state: _State, keys: Sequence[_Key]) -> list[Score]:
    """Score tests of the deterministic candidates; those found are tested given the others."""
    scores = []
    for kind, index in keys:
        if kind == "torque":
            continue
        before = _remove(problem, state, (kind, index))
        after = _add(problem, before, (kind, index))
        bare = problem.solve(before.level, before.chosen)[0]
        deviance, solution, covariance = problem.solve(after.level, after.chosen)
        size = solution[-len(problem.places[index]) :]
        sigma = np.sqrt(np.maximum(np.diag(covariance)[-len(size) :], np.finfo(float).tiny))
        most = int(np.argmax(np.abs(size) / sigma))
        effect = problem.effects[index]
        scores.append(
            Score(
                name=effect.name,
                title=effect.title,
                value=float(size[most]),
                sigma=float(sigma[most]),
                unit=effect.unit,
                significance=float(np.sqrt(max(bare - deviance, 0.0))),
            )
        )
    return scores


def diagnose(
    found: Sequence[Innovations],
    levels: Matrix,
    effects: Sequence[Nuisance],
    prior: tuple[Matrix, Vector],
    names: Sequence[str],
    scale: Vector,
    *,
    stated: bool,
) -> tuple[tuple[Finding, ...], tuple[Score, ...]]:
    """Find the effects that explain the residuals of a fit.

    Args:
        found: Whitened columns of each record: residual, n parameters, all effects.
        levels: Levels of ripple and random-walk torque, (g, 2).
        effects: Deterministic candidates, in the order of their columns.
        prior: Information matrix of the whitened parameters, (n, n), and the information vector,
            (n,).
        names: Names of the n estimated parameters.
        scale: Plausible sizes of the parameters, (n,), SI.
        stated: Whether the user stated the noise of the speed.

    Returns:
        Findings, the one with most evidence first; and the score test of every deterministic
        candidate that the record can show.
    """
    problem = _Problem(found, levels, effects, prior, stated)
    keys = _keys(problem)
    state = _select(problem, keys)
    findings = [
        _describe(problem, state, key, keys, names, scale)
        for key in keys
        if _is_present(problem, state, key)
    ]
    return by_evidence(findings), tuple(_scores(problem, state, keys))
