"""Search for test vectors along the margins of conditions.

For each evaluation that is sought, steps with a large margin are kept: the smallest difference that
separates a condition of it, or of the path to it, from its wanted value. A step that reaches the
decision is better than one that does not (Wegener, Baresel, Sthamer: Evolutionary test environment
for automatic structural testing, Information and Software Technology 43, 2001). One field at a time
is changed; the secant of the margin gives the change that brings it to zero (alternating variables:
Korel, Automated software test data generation, IEEE TSE 16, 1990). The limit of a sum of squares,
such as the size of a vector, is reached by several fields, each of which brings the margin to the
largest value of a parabola (successive parabolic interpolation: Brent, Algorithms for minimization
without derivatives, 1973, chapter 5). If C has one decision for each element of arrays, a step that
reaches it for one element reaches it for another one once these elements are exchanged.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from gyrostat.codegen.flight.reader.decisions import Decision
from gyrostat.exports.vectors.coverage import Goal
from gyrostat.exports.vectors.explore import Explorer
from gyrostat.exports.vectors.fields import arrays_of
from gyrostat.exports.vectors.proposals import SPECIAL
from gyrostat.exports.vectors.rows import Candidate

SHARES = (1.0, 1.0 + 1e-9, 1.001, 1.3, 2.5, 0.5)
"""Shares of the change that brings a margin to zero by its secant."""
STARTS = 40
"""Largest number of starts of the search for a goal."""
PATIENCE = 4
"""Number of rounds without progress after which a search starts anew."""


@dataclass
class Descent:
    """Progress towards a goal.

    Attributes:
        best: Best step; None before the first round.
        margin: Its margin.
        slopes: Field -> change of the margin by a unit of the field.
        peaks: Field -> its value with the largest margin, by a parabola.
        is_fresh: Whether no change was tried yet.
        idle: Number of rounds without an improvement.
        starts: Number of starts.
    """

    best: Candidate | None = None
    margin: float = -np.inf
    slopes: dict[int, float] = field(default_factory=dict)
    peaks: dict[int, float] = field(default_factory=dict)
    is_fresh: bool = True
    idle: int = 0
    starts: int = 0


class Descents:
    """Progress towards all goals of an explorer."""

    def __init__(
        self,
        explorer: Explorer,
        seeds: Sequence[Candidate],
        free: Sequence[int],
        doubtful: Collection[tuple[int, int]] = (),
    ) -> None:
        """Begin without progress.

        Args:
            explorer: Explorer.
            seeds: Steps that a search may start from.
            free: Fields that may be changed.
            doubtful: Conditions that may be impossible, which come after the others.
        """
        self._explorer = explorer
        self._seeds = seeds
        self._free = list(free)
        self._doubtful = frozenset(doubtful)
        self._arrays = arrays_of(explorer.machine.fields)
        self._alike: dict[object, list[int]] = {}
        for each in explorer.machine.decisions:
            self._alike.setdefault(_shape(each), []).append(each.number)
        self.goals: dict[Goal, Descent] = {}

    def round(self, most: int) -> bool:
        """Try changes for goals; whether there was one.

        Those with the fewest starts come first.

        Args:
            most: Number of steps after which no further goal is taken.
        """
        explorer = self._explorer
        wanted = [goal for each in explorer.coverage.decisions for goal in each.goals()]
        for goal in wanted:
            self.goals.setdefault(goal, Descent())
        wanted = [goal for goal in wanted if self.goals[goal].starts < STARTS]
        wanted.sort(key=lambda goal: (self._is_doubtful(goal), self.goals[goal].starts))
        every: list[Candidate] = []
        spans = []
        for goal in wanted:
            if len(every) > most:
                break
            descent = self.goals[goal]
            if descent.best is None or descent.idle > PATIENCE:
                descent = self._restart(goal, descent)
            base = descent.best
            assert base is not None
            tries = [(None, base), *self._tries(descent, base)]
            spans.append((goal, base, len(every), tries))
            every += [candidate for _, candidate in tries]
        if not every:
            return False
        explorer.evaluate(every, has_margins=True)
        for goal, base, start, tries in spans:
            if goal in explorer.margins:
                margins = explorer.margins[goal][:, start : start + len(tries)]
                self._learn(self.goals[goal], base, tries, margins)
        return True

    def _is_doubtful(self, goal: Goal) -> bool:
        sought = self._explorer.coverage.decisions[goal.decision].sought()
        return all((goal.decision, condition) in self._doubtful for condition in sought)

    def _restart(self, goal: Goal, descent: Descent) -> Descent:
        """Start from a step that evaluates the same decision or a similar one, or from any one."""
        every = self._explorer.coverage.decisions
        source = every[goal.decision].decision.source
        similar = [
            each.seen[goal.outcome]
            for each in every
            if each.decision.source == source and goal.outcome in each.seen
        ]
        seen = list(every[goal.decision].seen.values())
        exchanged = self._of_other_elements(goal)
        choices = [each for each in (exchanged, similar, seen, self._seeds) if each]
        chosen = choices[descent.starts % len(choices)]
        random = self._explorer.random
        best = chosen[int(random.integers(len(chosen)))]
        if best.situation.begins and random.integers(2):
            seed = self._seeds[int(random.integers(len(self._seeds)))]
            best = best.moved_to(seed.situation, self._explorer.inputs)
        self.goals[goal] = Descent(best, starts=descent.starts + 1)
        return self.goals[goal]

    def _of_other_elements(self, goal: Goal) -> list[Candidate]:
        """Steps that reach a goal for other elements of arrays, with the elements exchanged."""
        every = self._explorer.coverage.decisions
        alike = self._alike[_shape(every[goal.decision].decision)]
        arrays = [array for array in self._arrays if len(array) == len(alike) > 1]
        own, found = alike.index(goal.decision), []
        for other, number in enumerate(alike):
            if goal.outcome in every[number].seen:
                step = every[number].seen[goal.outcome]
                allowed, values, pairs = set(self._allowed(step)), step.values.copy(), []
                for array in arrays:
                    pair = [array[own], array[other]]
                    if allowed.issuperset(pair):
                        values[pair] = values[pair[::-1]]
                        pairs += pair
                found.append(self._changed(step, values, pairs))
        return found

    def _learn(
        self,
        descent: Descent,
        base: Candidate,
        tries: Sequence[tuple[int | None, Candidate]],
        margins: np.ndarray,
    ) -> None:
        (reaches, *reached), (before, *after) = margins
        tried = zip(tries[1:], reached, after, strict=True)
        points: dict[int, dict[float, float]] = {}
        for (k, candidate), is_reached, margin in tried:
            if k is None or is_reached != reaches:
                continue
            value, origin = float(candidate.values[k]), float(base.values[k])
            with np.errstate(all="ignore"):
                slope = (margin - before) / np.subtract(value, origin)
            if np.isfinite(slope) and slope != 0.0:
                descent.slopes[k] = float(slope)
                points.setdefault(k, {origin: before})[value] = margin
        for k, every in points.items():
            peak = _peak(every)
            if peak is not None:
                descent.peaks[k] = peak
        lane = max(range(len(tries)), key=lambda each: tuple(margins[:, each]))
        descent.margin, descent.idle = float(margins[1, lane]), descent.idle + 1
        if tuple(margins[:, lane]) > (reaches, before):
            descent.best, descent.idle = tries[lane][1], 0

    def _allowed(self, base: Candidate) -> list[int]:
        states = self._explorer.states if base.situation.begins else ()
        return [k for k in self._free if k not in states]

    def _tries(self, descent: Descent, base: Candidate) -> list[tuple[int | None, Candidate]]:
        """Steps with changes, and the field that is changed if it is a single one."""
        random, allowed = self._explorer.random, self._allowed(base)
        tries: list[tuple[int | None, Candidate]] = []
        slopes = descent.slopes
        # a start tries every field, later rounds go on with those that matter
        few = list(slopes) if len(slopes) <= 4 else random.choice(list(slopes), 4, replace=False)
        for k in (int(k) for k in few):
            with np.errstate(all="ignore"):
                change = -descent.margin / slopes[k]
                changed = [base.values[k] + share * change for share in SHARES]
            if np.isfinite(change):
                tries += [(k, self._moved(base, k, value)) for value in changed]
        peaks = list(descent.peaks.items())
        for count in (1, 1, 2, 3, 3) if peaks else ():
            values = base.values.copy()
            chosen = [peaks[place] for place in random.permutation(len(peaks))[:count].tolist()]
            for k, value in chosen:
                values[k] = value
            tries.append((None, self._changed(base, values, [k for k, _ in chosen])))
        fresh = allowed if descent.is_fresh else random.choice(allowed, 6).tolist()
        descent.is_fresh = False
        for k in fresh:
            tries.append((k, self._moved(base, k, self._near(k, base.values))))
            special = SPECIAL.get(self._explorer.machine.fields[k].kind)
            if special:
                tries.append((k, self._moved(base, k, float(random.choice(special)))))
        for count in (2, 2, 3):
            values = base.values.copy()
            chosen = random.choice(allowed, count).tolist()
            for k in chosen:
                values[k] = self._near(k, values)
            tries.append((None, self._changed(base, values, chosen)))
        for count in (1, 2):
            values = base.values.copy()
            chosen = self._explorer.proposals.change(values, allowed, count)
            tries.append((None, self._changed(base, values, chosen)))
        return tries

    def _near(self, k: int, values: np.ndarray) -> float:
        """Value that differs moderately, so that numbers keep their order of magnitude."""
        random, kind = self._explorer.random, self._explorer.machine.fields[k].kind
        value = float(values[k])
        if kind == "logical":
            return 1.0 - value
        if kind == "integer":
            return value + float(random.choice([1, -1]))
        if random.integers(4) == 0:
            return self._explorer.proposals.value(k, values)
        value = value if np.isfinite(value) else 0.0
        size = abs(value) if value != 0.0 else 1.0
        return value + size * float(random.choice([1e-3, 0.3, 3.0, 30.0]) * random.normal())

    def _moved(self, base: Candidate, k: int, value: float) -> Candidate:
        values = base.values.copy()
        values[k] = value
        return self._changed(base, values, [k])

    def _changed(self, base: Candidate, values: np.ndarray, changed: Sequence[int]) -> Candidate:
        every = dict.fromkeys((*base.changed, *changed))
        kept = tuple(k for k in every if k not in self._explorer.inputs)
        return self._explorer.candidate(base.situation, values, kept)


def _shape(decision: Decision) -> object:
    """What decisions have in common that differ in the elements of arrays."""
    texts = (re.sub(r"\d+", "", condition) for condition in decision.conditions)
    return decision.source, decision.kind, str(decision.tree), *texts


def _peak(margins: Mapping[float, float]) -> float | None:
    """Value at the maximum of the parabola through the largest margin and its neighbours.

    Args:
        margins: Value of a field -> margin.

    Returns:
        The value; None if there are fewer than three, or the parabola has no maximum.
    """
    if len(margins) < 3:
        return None
    values = sorted(margins)
    place = values.index(max(margins, key=margins.__getitem__))
    first = min(max(place - 1, 0), len(values) - 3)
    a, b, c = values[first : first + 3]
    with np.errstate(all="ignore"):
        rise = np.divide(margins[b] - margins[a], b - a)
        bend = np.divide(np.divide(margins[c] - margins[b], c - b) - rise, c - a)
        peak = 0.5 * (a + b - rise / bend)
    return float(peak) if bend < 0.0 and np.isfinite(peak) else None
