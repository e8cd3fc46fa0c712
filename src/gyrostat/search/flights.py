"""Flights of a search: numbered, simulated in pieces, stored, and found again.

A search requests the same flights in the same order whenever it gets the same results. After an
interruption it starts again, and finds the results of stored pieces instead of simulating them.
"""

import contextlib
import itertools
from collections import defaultdict
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.draws import check_values, dispersed_relations, shares, values_at
from gyrostat.campaigns.engine import LANES
from gyrostat.campaigns.executors import Opener, carry_out
from gyrostat.campaigns.jobs import Job, work_here
from gyrostat.campaigns.noise import PARENT, REPLACED, noise_of, parts_of
from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.search.moves import FIRST, Answers, Moves

PIECE, SAMPLES = 64, 5_000_000
"""Largest number of flights that are simulated and stored together, and of their samples unless
these are `LANES` flights."""
Columns = Mapping[str, Vector]


class Piece(NamedTuple):
    """Flights that are simulated together.

    Attributes:
        number: Number of the piece.
        runs: Numbers of the flights, (n,).
        values: Dispersed values, (n, keys).
        variant: Index of their scenario.
    """

    number: int
    runs: NDArray[np.int64]
    values: Matrix
    variant: int = 0


class Flights:
    """Flights of a search.

    Args:
        scenario: Scenario.
        campaign: Campaign of the search.
        response: Columns of a table -> response of its runs.
        found: Piece -> its stored columns; None if there are none.
        store: Called with the number of a simulated piece and its columns.
        opener: Opens the executor; None if every piece is stored.
        workers: Number of its workers.
        on_progress: Called with the number of finished flights.
        variants: Scenarios that flights can have instead, with the same dispersed keys; the first
            is `scenario`.

    Attributes:
        count: Number of flights.
        refused: Number of requested flights whose values are not allowed.
    """

    def __init__(
        self,
        scenario: Scenario,
        campaign: Campaign,
        response: Callable[[Columns], Vector],
        *,
        found: Callable[[Piece], Columns | None],
        store: Callable[[int, Columns], None] = lambda number, columns: None,
        opener: Opener | None = None,
        workers: int = 1,
        on_progress: Callable[[int], None] = lambda count: None,
        variants: Sequence[Scenario] = (),
    ):
        self.count = self.refused = self._pieces = 0
        self._scenario, self._campaign, self._response = scenario, campaign, response
        self._relations = dispersed_relations(scenario)
        self._found, self._store, self._opener = found, store, opener
        self._window = 2 * workers + 2
        self._on_progress = on_progress
        self._variants = variants or (scenario,)
        self._campaigns = [
            replace(campaign, scenario=each.text(), digest=each.digest()) for each in self._variants
        ]
        self._variant_of = np.zeros(0, np.int64)
        self._parents, self._shares = np.zeros(0, np.int64), np.zeros(0)

    def fly(self, moves: Sequence[Moves]) -> list[Answers]:
        """Simulate all requested flights together.

        Raises:
            InputError: A value of a flight with independent draws is not allowed, or the stored
                results are those of another search.
        """
        requests = [self._register(each) for each in moves]
        values = np.concatenate([each for _, _, each in requests])
        numbers = np.concatenate([each for each, _, _ in requests])
        valid = numbers >= 0
        rows = self._fly(numbers[valid], values[valid])
        responses = np.full((len(numbers), *rows.shape[1:]), -np.inf)
        responses[valid] = rows
        ends = np.cumsum([len(each) for each, _, _ in requests])[:-1]
        parts = np.split(responses, ends)
        return [Answers(*each[:2], part) for each, part in zip(requests, parts, strict=True)]

    def _register(self, moves: Moves) -> tuple[NDArray[np.int64], Matrix, Matrix]:
        """Numbers, standard normal numbers and values of requested flights."""
        scenario, first = self._scenario, self.count
        if moves.values is not None:
            numbers, values = first + np.arange(moves.size), moves.values
            normal, fine = np.full(values.shape, np.nan), np.ones(moves.size, bool)
        elif moves.normal is None:
            numbers = first + np.arange(moves.size)
            share = shares(scenario, self._campaign.seed, numbers)
            normal, values = ndtri(share), values_at(scenario, share)
            check_values(scenario, range(first, first + moves.size), values, self._relations)
            fine = np.ones(moves.size, bool)
        else:
            normal = moves.normal
            values = values_at(scenario, ndtr(normal))
            fine = allowed(scenario, values, self._relations)
            numbers = np.where(fine, first + np.cumsum(fine) - 1, FIRST)
        self.count += int(np.sum(fine))
        self.refused += int(np.sum(~fine))
        self._parents = np.concatenate([self._parents, moves.parents[fine]])
        self._shares = np.concatenate([self._shares, np.full(int(np.sum(fine)), moves.share)])
        variants = np.zeros(moves.size, np.int64) if moves.variants is None else moves.variants
        self._variant_of = np.concatenate([self._variant_of, variants[fine]])
        return numbers, normal, values

    def _fly(self, numbers: NDArray[np.int64], values: Matrix) -> Vector:
        """Responses of numbered flights."""
        pieces, size = [], min(PIECE, max(LANES, SAMPLES // (self._scenario.count + 1)))
        variants = self._variant_of[numbers]
        edges = [0, *(np.flatnonzero(np.diff(variants)) + 1).tolist(), len(numbers)]
        for start, end in itertools.pairwise(edges):
            for first in range(start, end, size):
                part = slice(first, min(first + size, end))
                variant = int(variants[first])
                pieces.append(Piece(self._pieces, numbers[part], values[part], variant))
                self._pieces += 1
        tables = {piece.number: self._found(piece) for piece in pieces}
        pending = [piece for piece in pieces if tables[piece.number] is None]
        waiting = {piece.number: piece for piece in pending}
        progress = self.count - sum(len(piece.runs) for piece in pending)

        def take(job: Job, results: Any) -> None:
            nonlocal progress
            piece = waiting[job.block]
            columns = {**results.columns, **self._noise_columns(piece)}
            self._store(piece.number, columns)
            tables[piece.number] = columns
            progress += len(piece.runs)
            self._on_progress(progress)

        if pending:
            if self._opener is None:
                raise InputError(
                    "search: found requested runs that are not in the table, expected all of them: "
                    "use the version that started it, or another folder"
                )
            jobs = map(self._job, pending)
            carry_out(jobs, work_here, self._opener, take, window=self._window)
        if not pieces:
            return self._response(defaultdict(lambda: np.zeros(0)))
        responses = []
        for piece in pieces:
            columns: Any = tables[piece.number]
            if not self._matches(piece, columns):
                raise InputError(
                    f"block {piece.number}: found the values of another search, expected those "
                    "that this software draws: use the version that started it, or another folder"
                )
            responses.append(self._response(columns))
        return np.concatenate(responses)

    def _matches(self, piece: Piece, columns: Columns) -> bool:
        """Whether columns have the values and the noise of the flights that were requested."""
        expected = dict(zip(self._scenario.dispersed, piece.values.T, strict=True))
        expected |= self._noise_columns(piece)
        return all(np.array_equal(columns[name], each) for name, each in expected.items())

    def _job(self, piece: Piece) -> Job:
        """Job that simulates a piece."""
        scenario, seed = self._variants[piece.variant], self._campaign.seed
        keys = noise_of(piece.runs, self._parents, self._shares, seed, parts_of(scenario))
        runs, campaign = tuple(piece.runs.tolist()), self._campaigns[piece.variant]
        return Job(campaign, runs, (), piece.number, (piece.values, keys))

    def _noise_columns(self, piece: Piece) -> dict[str, Any]:
        return {PARENT: self._parents[piece.runs], REPLACED: self._shares[piece.runs]}


def allowed(scenario: Scenario, values: Matrix, relations: Sequence[Relation]) -> NDArray[np.bool_]:
    """Whether the dispersed values of runs are allowed, (n,); see `check_values`."""

    def check(rows: range) -> bool:
        with contextlib.suppress(InputError):
            check_values(scenario, rows, values[rows.start : rows.stop], relations)
            return True
        return False

    if check(range(len(values))):
        return np.ones(len(values), bool)
    return np.array([check(range(k, k + 1)) for k in range(len(values))])


def together(
    searches: Sequence[Generator[Moves, Answers, Any]], fly: Callable[[list[Moves]], list[Answers]]
) -> list[Any]:
    """Results of independent searches whose flights are simulated together."""
    results: list[Any] = [None] * len(searches)
    requests = {index: next(search) for index, search in enumerate(searches)}
    while requests:
        answers = fly([*requests.values()])
        pending = {}
        for index, answer in zip(requests, answers, strict=True):
            try:
                pending[index] = searches[index].send(answer)
            except StopIteration as end:
                results[index] = end.value
        requests = pending
    return results
