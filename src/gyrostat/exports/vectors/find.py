"""Find test vectors that show every decision and condition of emitted C."""

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gyrostat.codegen.flight.module import Module, Precision
from gyrostat.exports.reasons import Reasons
from gyrostat.exports.target import Target
from gyrostat.exports.vectors.agreement import Agreement
from gyrostat.exports.vectors.conditioning import conditioning
from gyrostat.exports.vectors.coverage import Coverage
from gyrostat.exports.vectors.descend import Descents
from gyrostat.exports.vectors.explore import Explorer
from gyrostat.exports.vectors.justifications import Gap, justified
from gyrostat.exports.vectors.machine import Machine
from gyrostat.exports.vectors.python_run import PythonRun
from gyrostat.exports.vectors.rows import Candidate, Row, Situation
from gyrostat.exports.vectors.selection import Item, Replay, choose, items_of, replay, wanted_items
from gyrostat.exports.vectors.vectors import Vectors, nominal_rows

MOST, EACH = 1e7, 1e5
"""Largest effort of a search, and for each condition if that is more: one to two minutes."""
DOUBTFUL = 0.3
"""Share of the largest effort for conditions that may be impossible."""
LANES = 256
"""Number of steps that are tried at once."""


@dataclass(frozen=True)
class Found:
    """Test vectors and what they show.

    Attributes:
        vectors: Test vectors.
        coverage: Evaluations of every decision, with the rows that show them.
        share: Effort of the search over its largest one.
        seconds: Time of the search, s.
        reasons: What cannot be shown -> the reason.
        possible: What cannot be shown if a review confirms the reason -> the reason.
    """

    vectors: Vectors
    coverage: Coverage
    share: float
    seconds: float
    reasons: Mapping[Gap, str]
    possible: Mapping[Gap, str]

    def message(self) -> str:
        """One line about the search for the user."""
        every = self.coverage.decisions
        conditions = sum(each.decision.size for each in every)
        shown = conditions - sum(len(each.missing()) for each in every)
        return (
            f"vectors: {len(self.vectors.rows)} steps show {shown} of {conditions} conditions "
            f"(search: {self.seconds:.0f} s, {100.0 * min(self.share, 1.0):.0f} % of its limit)"
        )


def find_vectors(
    target: Target,
    module: Module,
    precision: Precision,
    own: Reasons | None = None,
    most: float | None = None,
) -> Found:
    """Find test vectors for a flight module.

    Args:
        target: Flight module.
        module: Its C code.
        precision: Precision of its real numbers.
        own: Reasons of the user.
        most: Largest effort of the search, see `Explorer.effort`; by default `MOST` or `EACH` for
            each condition.

    Raises:
        InputError: A reason of the user is about no decision.
        UnreadableError: The C code cannot be read back.
    """
    began = time.monotonic()
    machine = Machine(target, module, precision)
    fields, conditions = machine.fields, sum(each.size for each in machine.decisions)
    most = max(MOST, EACH * conditions) if most is None else most
    nominal = [
        Row(row.begins, machine.rounded(row.changes)) for row in nominal_rows(target, fields)
    ]
    python = PythonRun(target, fields, is_compiled=True)
    inputs = np.array([[*row.changes.values()] for row in nominal])
    own = own or Reasons()
    own.check(machine.decisions)
    reasons, possible = (
        justified(module.name, machine.decisions, own.justified, is_sure=sure)
        for sure in (True, False)
    )
    unreachable = {(gap.decision, gap.condition) for gap in reasons}
    explorer = Explorer(machine, python.tuned, inputs, unreachable)
    results = python.run(nominal)
    # XLA and NumPy evaluate in different orders, as C does
    otherwise = PythonRun(target, fields, is_compiled=False).run(nominal)
    rounding = conditioning(python, fields, nominal, results, precision, otherwise)
    agreement = Agreement(fields, results, precision, rounding)
    explorer.evaluate(_cases(target, explorer))
    _search(explorer, python, agreement, most, {(g.decision, g.condition) for g in possible})
    rows, replayed, values = _select(explorer, python, agreement, nominal)
    coverage = Coverage(machine.decisions)
    for number, items in enumerate(replayed.items):
        for decision, outcome in sorted(items):
            coverage.decisions[decision].add(outcome, number)
    vectors = Vectors(fields, tuple(rows), values, rounding)
    share, seconds = explorer.effort / max(most, 1.0), time.monotonic() - began
    return Found(vectors, coverage, share, seconds, reasons, possible)


def _cases(target: Target, explorer: Explorer) -> list[Candidate]:
    """Steps that the module names as of interest."""
    places = {field.name: k for k, field in enumerate(explorer.machine.fields)}
    start = explorer.changed(Situation((), (explorer.tuned,)), (), 0)
    candidates = []
    for case in target.cases:
        values = start.values.copy()
        # a law of friction has parameters of its own
        known = [places[name] for name in case if name in places]
        values[known] = [value for name, value in case.items() if name in places]
        changed = tuple(k for k in known if k not in explorer.inputs)
        candidates.append(explorer.candidate(start.situation, values, changed))
    return candidates


def _search(
    explorer: Explorer,
    python: PythonRun,
    agreement: Agreement,
    most: float,
    doubtful: Collection[tuple[int, int]],
) -> None:
    """Look for steps that show something new: simple ones first.

    Args:
        explorer: Explorer.
        python: Functions in Python.
        agreement: Comparison of C and Python.
        most: Largest effort.
        doubtful: Conditions that may be impossible; a share of the effort is for them alone.
    """

    def limit() -> float:
        missing = {(d.decision.number, k) for d in explorer.coverage.decisions for k in d.sought()}
        return most if missing - set(doubtful) else DOUBTFUL * most

    verify = partial(explorer.verify, python, agreement)
    tuned = explorer.fields("parameter", "constant")
    history = explorer.sequences((), LANES, 12)
    explorer.sequences(tuned, LANES, 4)
    verify()
    situations = [
        Situation((), (explorer.tuned,)),
        *(history[step][0] for step in (0, 1, 3)),
        *(situation for step in (1, 3) for situation in history[step][1:40]),
    ]
    situations = [s for s in situations if explorer.start(s, python, agreement) is not None]
    inputs = explorer.inputs
    for _ in range(5):
        explorer.steps(situations, (*inputs, *tuned), LANES)
        verify()
    every = (*inputs, *tuned, *explorer.states)
    for _ in range(10):
        explorer.steps(situations, every, LANES)
        verify()
    seeds = [explorer.changed(situation, inputs, 0) for situation in situations]
    descents = Descents(explorer, seeds, every, doubtful)
    while explorer.effort < limit() and descents.round(4 * LANES):
        verify()


def _select(
    explorer: Explorer, python: PythonRun, agreement: Agreement, nominal: Sequence[Row]
) -> tuple[list[Row], Replay, np.ndarray]:
    """Choose rows; C and Python agree in all of them to rounding errors."""
    machine, candidates = explorer.machine, explorer.candidates
    items = items_of(machine, candidates)
    base: set[Item] = set().union(*replay(machine, explorer.tuned, nominal).items)
    while True:
        wanted = wanted_items(machine.decisions, base.union(*items))
        rows: list[Row] = [*nominal]
        owners = [-1] * len(nominal)
        for k in choose(candidates, items, wanted - base):
            more = candidates[k].rows(explorer.inputs)
            rows += more
            owners += [k] * len(more)
        replayed, values = replay(machine, explorer.tuned, rows), python.run(rows)
        good = agreement.agree(replayed.values, values)
        wrong = {owners[k] for k in np.flatnonzero(~good).tolist()} - {-1}
        if not wrong:
            return rows, replayed, values
        # a sequence may differ where its start differs by rounding errors
        for k in wrong:
            items[k] = set()
