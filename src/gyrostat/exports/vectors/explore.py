"""Search for test vectors by random changes of a run."""

from collections.abc import Collection, Sequence

import numpy as np

from gyrostat.exports.vectors.agreement import Agreement
from gyrostat.exports.vectors.coverage import Coverage, Goal
from gyrostat.exports.vectors.machine import ALL_PASSES, Machine
from gyrostat.exports.vectors.proposals import Proposals
from gyrostat.exports.vectors.python_run import PythonRun
from gyrostat.exports.vectors.rows import Candidate, Situation, groups

LONG_PASSES = 64
"""Number of passes of a loop for a second run of steps that were given up."""
LONG_RUNS, LONG_LANES = 10, 4
"""Largest number of runs to the end of loops, and of steps in such a run."""


class Explorer:
    """Evaluates steps and keeps those that show something new.

    Attributes:
        machine: Functions of the module.
        coverage: What was seen, with candidates as the inputs.
        inputs: Indices of the fields that are inputs.
        tuned: Values of all fields before the first step.
        nominal: Inputs of the run that is changed, (steps, inputs).
        proposals: Random changes.
        margins: Goal -> whether each candidate of the last evaluation with margins reaches the
            decision, and its margin, (2, candidates).
        effort: Work of the machine so far.
    """

    def __init__(
        self,
        machine: Machine,
        tuned: np.ndarray,
        nominal: np.ndarray,
        unreachable: Collection[tuple[int, int]] = (),
    ) -> None:
        """Begin without a step.

        Args:
            machine: Functions of the module.
            tuned: Values of all fields before the first step.
            nominal: Inputs of the run that is changed, (steps, inputs).
            unreachable: Number of a decision and index of a condition that is not sought.
        """
        self.machine = machine
        self.coverage = Coverage(machine.decisions, unreachable)
        self.inputs = self.fields("input")
        self.states = frozenset(self.fields("state"))
        self.tuned = tuned
        self.nominal = nominal
        self.proposals = Proposals(machine.fields, machine.limits)
        self.margins: dict[Goal, np.ndarray] = {}
        self.effort = 0.0
        self._verified: dict[int, Candidate] = {}
        self._long_runs = 0
        self._wrong: set[int] = set()
        self._starts: dict[int, tuple[Situation, np.ndarray | None]] = {}

    @property
    def random(self) -> np.random.Generator:
        """Generator of all random changes."""
        return self.proposals.random

    def fields(self, *roles: str) -> tuple[int, ...]:
        """Indices of the fields of given roles."""
        return tuple(k for k, f in enumerate(self.machine.fields) if f.role in roles)

    def evaluate(self, candidates: Sequence[Candidate], *, has_margins: bool = False) -> np.ndarray:
        """Run a step from each candidate and keep what is new; values of all fields after it.

        The values are NaN after a step that was given up.
        """
        after = np.full((len(self.tuned), len(candidates)), np.nan)
        self.margins = {}
        for begins, group in groups(candidates):
            self.coverage.begin(self.machine.need)
            results = self.machine.run(
                np.stack([candidates[k].values for k in group], axis=1),
                self.coverage.record,
                begins=begins,
                has_margins=has_margins,
            )
            self.effort += self.machine.work
            dead = self.machine.dead
            after[:, group] = np.where(dead, np.nan, results)
            self._add_hits([candidates[k] for k in group])
            for goal, least in self.coverage.margins.items():
                every = self.margins.setdefault(goal, np.full((2, len(candidates)), -np.inf))
                every[:, group] = np.where(dead, -np.inf, least)
            if dead.any() and not self._loops_are_shown():
                lanes = np.flatnonzero(dead).tolist()
                self._run_long([candidates[group[lane]] for lane in lanes], begins=begins)
        return after

    def _add_hits(self, candidates: Sequence[Candidate]) -> None:
        for number, outcome, lane in self.coverage.hits:
            if id(candidates[lane]) not in self._wrong:
                self.coverage.decisions[number].add(outcome, candidates[lane])

    def _loops_are_shown(self) -> bool:
        loops = [d for d in self.coverage.decisions if d.decision.kind == "for"]
        return self._long_runs >= LONG_RUNS or not any(each.sought() for each in loops)

    def _run_long(self, candidates: Sequence[Candidate], *, begins: bool) -> None:
        """Run steps that were given up: further, and a few of them to the end of their loops."""
        for passes, lanes in ((LONG_PASSES, None), (ALL_PASSES, LONG_LANES)):
            candidates = candidates[:lanes]
            self.coverage.begin(self.machine.need)
            values = np.stack([c.values for c in candidates], axis=1)
            with self.machine.up_to(passes):
                self.machine.run(values, self.coverage.record, begins=begins)
            self.effort += self.machine.work
            self._add_hits(candidates)
            candidates = [c for c, d in zip(candidates, self.machine.dead, strict=True) if d]
            if not candidates:
                break
        else:
            self._long_runs += 1

    @property
    def candidates(self) -> list[Candidate]:
        """Steps that show something."""
        every = {id(c): c for each in self.coverage.decisions for c in each.seen.values()}
        return list(every.values())

    def verify(self, python: PythonRun, agreement: Agreement) -> None:
        """Remove the steps since the last call whose results in Python are others."""
        fresh = [c for c in self.candidates if id(c) not in self._verified]
        wrong: set[int] = set()
        for begins, group in groups(fresh):
            self.machine.need[:] = [False] * len(self.machine.need)
            values = np.stack([fresh[k].values for k in group], axis=1)
            with self.machine.up_to(ALL_PASSES):
                code = self.machine.run(values, self.coverage.record, begins=begins).T
            for lane, k in enumerate(group):
                if not self._agrees(fresh[k], python, agreement, code[lane]):
                    wrong.add(id(fresh[k]))
        self._wrong |= wrong
        for each in self.coverage.decisions:
            each.remove(wrong)
        # keep the steps alive, so that no other one gets their identity
        self._verified |= {id(c): c for c in fresh}

    def start(
        self, situation: Situation, python: PythonRun, agreement: Agreement
    ) -> np.ndarray | None:
        """Values of all fields in a situation in Python; None if the results of a step differ."""
        if situation.begins:
            return self.tuned
        if id(situation) not in self._starts:
            history = python.run(situation.rows)
            same = agreement.agree(np.array(situation.history[1:]), history).all()
            self._starts[id(situation)] = (situation, history[-1] if same else None)
        return self._starts[id(situation)][1]

    def _agrees(
        self, candidate: Candidate, python: PythonRun, agreement: Agreement, after: np.ndarray
    ) -> bool:
        """Whether Python gives the same results in all rows of a candidate.

        Args:
            candidate: Candidate.
            python: Functions in Python.
            agreement: Comparison.
            after: Values of all fields after its last row.
        """
        situation = candidate.situation
        values = candidate.values.copy()
        if not situation.begins:
            start = self.start(situation, python, agreement)
            if start is None:
                return False
            kept = np.ones(len(values), bool)
            kept[[*candidate.changed, *self.inputs]] = False
            values = np.where(kept, start, values)
        results = python.step(values, begins=situation.begins)
        return bool(agreement.agree(after[None], results[None])[0])

    def changed(self, situation: Situation, free: Sequence[int], count: int) -> Candidate:
        """Step with random changes of some fields, with inputs of the nominal run."""
        values = situation.values.copy()
        values[list(self.inputs)] = self.nominal[len(situation.rows) % len(self.nominal)]
        if situation.begins:
            free = [k for k in free if k not in self.states]
        changed = self.proposals.change(values, free, count)
        kept = tuple(k for k in changed if k not in self.inputs)
        return self.candidate(situation, values, kept)

    def candidate(
        self, situation: Situation, values: np.ndarray, changed: tuple[int, ...]
    ) -> Candidate:
        """Step with values that are rounded as the C code holds them; they change in place."""
        set_here = [*changed, *self.inputs]
        rounded = self.machine.rounded({k: float(values[k]) for k in set_here})
        values[set_here] = [rounded[k] for k in set_here]
        return Candidate(situation, values, changed)

    def sequences(self, free: Sequence[int], lanes: int, steps: int) -> list[list[Situation]]:
        """Run sequences of steps with random changes of inputs.

        Args:
            free: Fields other than inputs that the first step may change.
            lanes: Number of sequences; the first one has no changes.
            steps: Number of steps.

        Returns:
            For each step, the situation after it in each sequence.
        """
        situations = [Situation((), (self.tuned,))] * lanes
        history = []
        for step in range(steps):
            candidates = []
            for lane, situation in enumerate(situations):
                count = 0 if lane == 0 else int(self.random.choice([0, 1, 1, 2, 5]))
                if step == 0 and free and lane % 2:
                    candidates.append(self.changed(situation, free, max(count, 1)))
                else:
                    candidates.append(self.changed(situation, self.inputs, count))
            after = self.evaluate(candidates)
            situations = [
                Situation(c.rows(self.inputs), (*c.situation.history, after[:, k]))
                for k, c in enumerate(candidates)
            ]
            history.append(situations)
        return history

    def steps(self, situations: Sequence[Situation], free: Sequence[int], lanes: int) -> None:
        """Run single steps with random changes.

        Args:
            situations: Where they start.
            free: Fields that may be changed.
            lanes: Number of steps.
        """
        self.evaluate(
            [
                self.changed(
                    situations[int(self.random.integers(len(situations)))],
                    free,
                    int(self.random.choice([1, 1, 2, 3, 6])),
                )
                for _ in range(lanes)
            ]
        )
