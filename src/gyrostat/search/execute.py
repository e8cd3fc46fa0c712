"""Execution of a search from the first flight to the table of results, resumable."""

from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from gyrostat.campaigns.blocks import columns_of, table_at
from gyrostat.campaigns.cluster import Cluster
from gyrostat.campaigns.description import Campaign
from gyrostat.campaigns.execute import replay
from gyrostat.campaigns.executors import Opener, kept_open, threads
from gyrostat.campaigns.handshake import handshake
from gyrostat.campaigns.jobs import ELSEWHERE, work_here
from gyrostat.campaigns.noise import parts_of
from gyrostat.campaigns.ready import prepare
from gyrostat.campaigns.store import Store
from gyrostat.core.files import set_aside
from gyrostat.core.processors import usable_cores
from gyrostat.core.types import Vector
from gyrostat.core.validation import check_seed
from gyrostat.runs.fingerprint import FLAGS, Record, engine_record, refuse_other
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.search.flights import PIECE, Columns, Flights, Piece, together
from gyrostat.search.moves import Answers, Moves


class Question(Protocol):
    """Protocol of what a search asks."""

    def options(self) -> dict[str, Any]:
        """Options that campaign.json stores."""
        ...

    def response(self, columns: Columns) -> Vector:
        """Response of runs, (runs,), from the columns of their table: the larger the worse."""
        ...

    def searches(self, runs: int, seed: int) -> Sequence[Generator[Moves, Answers, Any]]:
        """Independent searches, for a largest number of runs.

        Raises:
            InputError: There are too few runs.
        """
        ...


class Options(NamedTuple):
    """Options of the execution of a search.

    Attributes:
        runs: Largest number of runs.
        seed: Seed of the draws.
        workers: Number of threads; None for one for each core. Of an executor, the number of its
            workers; see `gyrostat.campaigns.jobs.executor_for`.
        worst: Number of worst runs whose histories are kept.
        force: See `gyrostat.campaigns.run_campaign`.
        verify: See `gyrostat.campaigns.native.program_of`.
        opener: Opens the executor; None for threads of this process.
    """

    runs: int
    seed: int = 0
    workers: int | None = None
    worst: int = 3
    force: bool = False
    verify: bool = False
    opener: Opener | None = None


def run_search(
    scenario: Scenario,
    out: Path,
    question: Question,
    options: Options,
    *,
    on_progress: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] = lambda text: None,
    variants: Sequence[Scenario] = (),
) -> Path:
    """Carry out a search and store every run, or resume an interrupted search.

    Args:
        scenario: Scenario with dispersions.
        out: Folder of the search.
        question: What is searched.
        options: Options.
        on_progress: Called with the number of finished runs and the largest number of runs.
        say: Called with each message for the user.
        variants: See `gyrostat.search.flights.Flights`.

    Returns:
        Path of the table of all runs.

    Raises:
        InputError: There are too few runs, the native engine cannot simulate the scenario, or the
            folder has another campaign.
    """
    check_seed(options.seed)
    question.searches(options.runs, options.seed)  # before compiling
    scenarios = *variants, scenario
    for variant in {structure_of(each): each for each in scenarios}.values():
        prepare(variant, parts=parts_of(variant), verify=options.verify)
    record = engine_record("cpu", FLAGS["cpu"], "native")
    description = scenario.text(), scenario.digest(), options.seed, options.runs, PIECE, record
    store = Store(out, say)
    with store.locked():
        campaign = store.begin(Campaign(*description, question.options()), force=options.force)
        refuse_other(campaign.engine, str(out))
        store.check(campaign)
        opener, workers = _executor(options, record, scenarios)
        with kept_open(opener) as pool:
            flown = scenario, campaign, question, pool, workers, on_progress
            count = _fly(store, *flown, variants)
            store.merge(campaign, count)
            numbers = sorted(_worst(store, question, options.worst) - store.histories(campaign))
            replay(store, campaign, numbers, pool, fly_job=work_here)
    return store.table


def _executor(
    options: Options, record: Record, scenarios: Sequence[Scenario]
) -> tuple[Opener, int]:
    """Executor of a search and the number of its workers."""
    if isinstance(options.opener, Cluster):
        asked = handshake(record, [(each, parts_of(each)) for each in scenarios])
        return options.opener.with_handshake(asked), options.workers or ELSEWHERE
    workers = options.workers or usable_cores()
    return options.opener or threads(workers), workers


def _fly(
    store: Store,
    scenario: Scenario,
    campaign: Campaign,
    question: Question,
    pool: Opener,
    workers: int,
    on_progress: Callable[[int, int], None] | None,
    variants: Sequence[Scenario],
) -> int:
    """Carry out a search; returns the number of its blocks."""
    blocks, damaged = store.blocks(campaign)
    count = 0

    def load(piece: Piece) -> Columns | None:
        nonlocal count
        count = piece.number + 1
        if piece.number not in blocks:
            return None
        return columns_of(table_at(blocks[piece.number]))

    def keep(number: int, columns: Columns) -> None:
        for path in damaged.get(number, ()):
            store.say(f"{path}: found a damaged block: its runs were simulated again")
            set_aside(path)
        store.write_block(campaign, number, columns)

    def tell(runs: int) -> None:
        if on_progress is not None:
            on_progress(runs, campaign.runs)

    flights = Flights(
        *(scenario, campaign, question.response),
        found=load,
        store=keep,
        opener=pool,
        workers=workers,
        on_progress=tell,
        variants=variants,
    )
    together(question.searches(campaign.runs, campaign.seed), flights.fly)
    return count


def _worst(store: Store, question: Question, count: int) -> set[int]:
    """Numbers of the runs with the largest response."""
    response = question.response(columns_of(store.read_table()))
    return set(np.argsort(-response, kind="stable")[:count].tolist())


class Stored(NamedTuple):
    """Finished search.

    Attributes:
        campaign: Its description.
        scenario: Its scenario.
        columns: Columns of the table of runs.
    """

    campaign: Campaign
    scenario: Scenario
    columns: dict[str, Vector]

    def options(self) -> Mapping[str, Any]:
        """Options of the search."""
        return self.campaign.search or {}

    def results(self, question: Question) -> tuple[list[Any], int]:
        """Results of the independent searches, and the number of runs with refused values."""

        def load(piece: Piece) -> Columns | None:
            if piece.runs[-1] >= len(self.columns["run"]):
                return None
            return {name: values[piece.runs] for name, values in self.columns.items()}

        flights = Flights(self.scenario, self.campaign, question.response, found=load)
        searches = question.searches(self.campaign.runs, self.campaign.seed)
        return together(searches, flights.fly), flights.refused


def stored_search(folder: Path) -> Stored:
    """Read a finished search.

    Args:
        folder: Folder of the search.

    Raises:
        InputError: The folder has no finished search.
    """
    store = Store(folder)
    campaign = store.known()
    columns = columns_of(store.read_table())
    return Stored(campaign, Scenario.from_text(campaign.scenario), columns)
