"""Execution of a campaign, from the first run to the table of results, resumable."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from gyrostat.campaigns.description import Campaign, DamagedError
from gyrostat.campaigns.executors import Opener, carry_out, kept_open
from gyrostat.campaigns.jobs import Job, executor_for, work
from gyrostat.campaigns.store import Store
from gyrostat.campaigns.worst import worst_runs
from gyrostat.core.engines import ACCELERATED, ENGINES, engine_named, say_slower
from gyrostat.core.errors import InputError
from gyrostat.core.files import set_aside
from gyrostat.core.validation import check_seed
from gyrostat.runs.fingerprint import FLAGS, engine_record, refuse_other
from gyrostat.scenario.scenario import Scenario

BLOCK = 64
"""Least number of runs in a block; the same as the number of runs that are simulated together."""
BLOCKS = 2048
"""Number of blocks above which blocks have more runs: each is a file."""
ACCELERATED_BLOCK = 16384
"""Number of runs in a block of an accelerator, of which it computes several at a time."""
AT_ONCE = 8
"""Number of runs that are replayed together; their histories are in memory at the same time."""
MOST_RUNS = 2**32
"""Largest number of runs; the random generator uses run numbers of 32 bits."""


def chosen_engine(
    engine: str,
    scenario: Scenario,
    device: str,
    say: Callable[[str], None] = lambda text: None,
    *,
    verify: bool = False,
) -> str:
    """Choose the engine for a scenario, and compile for it unless it is JAX.

    Args:
        engine: "jax", "native", "opencl", "cuda", or "auto": native if possible on this machine.
        scenario: Scenario.
        device: "cpu" or "gpu".
        say: Called with a message that explains why "auto" chose JAX.
        verify: See `gyrostat.campaigns.native.program_of`.

    Raises:
        InputError: The engine cannot simulate this scenario on this machine.
    """
    if engine == "jax" or (engine == "auto" and device != "cpu"):
        return "jax"
    if device != "cpu":
        what = "it has a device of its own" if engine in ACCELERATED else "it is compiled C"
        name = engine if engine in ACCELERATED else "native"
        raise InputError(f"--engine {name}: found --device gpu, expected cpu: {what}")
    from gyrostat.campaigns.ready import prepare

    if engine in ACCELERATED:
        prepare(scenario, verify=verify, engine=engine)
        return engine
    try:
        prepare(scenario, verify=verify)
    except InputError as error:
        if engine == "native":
            raise
        say_slower(error, say)
        return "jax"
    return "native"


def described(
    scenario: Scenario,
    *,
    runs: int,
    seed: int,
    engine: str,
    device: str = "cpu",
    block: int | None = None,
) -> Campaign:
    """Description of a new campaign; the arguments are those of `run_campaign`.

    Args:
        scenario: Scenario.
        runs: Number of runs.
        seed: Seed of the draws.
        engine: Engine that `chosen_engine` returned.
        device: "cpu" or "gpu".
        block: Number of runs in a block; None: a multiple of `BLOCK`, or of `ACCELERATED_BLOCK`.
    """
    least = ACCELERATED_BLOCK if engine in ACCELERATED else BLOCK
    block = block or least * max(1, -(-runs // (BLOCKS * least)))
    record = engine_record(device, FLAGS[device], engine)
    return Campaign(scenario.text(), scenario.digest(), seed, runs, block, record)


def run_campaign(
    scenario: Scenario,
    out: Path,
    *,
    runs: int,
    seed: int = 0,
    device: str = "cpu",
    engine: str = "auto",
    opener: Opener | None = None,
    workers: int | None = None,
    block: int | None = None,
    keep: Sequence[int] = (),
    worst: int = 3,
    worst_by: str | None = None,
    force: bool = False,
    verify: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
    say: Callable[[str], None] = lambda text: None,
    fly_job: Callable[[Job], Any] | None = None,
) -> Path:
    """Run a campaign, or resume it.

    Args:
        scenario: Scenario with dispersions.
        out: Folder of the campaign.
        runs: Number of runs.
        seed: Seed of the draws.
        device: "cpu" or "gpu".
        engine: See `chosen_engine`. When a campaign is resumed, "auto" is its engine.
        opener: See `executor_for`.
        workers: See `executor_for`.
        block: Number of runs in a block; the results do not depend on it. None: see `described`.
        keep: Indices of runs whose histories are kept.
        worst: Number of worst runs whose histories are kept in addition.
        worst_by: Metric that ranks the worst runs; None for the last percentile of the error.
        force: Whether to start a new campaign in a folder with files that have the names of
            results; they are renamed NAME.changed.
        verify: See `gyrostat.campaigns.native.program_of`; for a new campaign.
        on_progress: Called with the number of completed runs and the total number of runs.
        say: Called with each message for the user.
        fly_job: See `executor_for`.

    Returns:
        Path of the table of all runs.

    Raises:
        InputError: The folder has another campaign, another engine or files of unknown origin, or
            cannot be written; a drawn value is not allowed; or the workers fail repeatedly.
    """
    from gyrostat.scenario.metrics.results import metrics_of, percentile_name

    check_seed(seed)
    if not 1 <= runs <= MOST_RUNS or (block is not None and block < 1):
        raise InputError(f"runs: found {runs}, expected 1 to {MOST_RUNS}")
    for run in keep:
        if run not in range(runs):
            raise InputError(f"kept run: found {run}, expected 0 to {runs - 1}")
    engine = engine_named(engine, say, "--engine", (*ENGINES, *ACCELERATED))
    metrics = metrics_of(scenario)
    worst_by = worst_by or percentile_name(scenario.percentiles[-1])
    if worst_by not in metrics:
        raise InputError(f"worst by: found {worst_by!r}, expected one of {', '.join(metrics)}")
    store = Store(out, say)
    try:
        existing = store.read()
    except DamagedError:  # may be repaired below
        existing = None
    if existing is None:
        engine = chosen_engine(engine, scenario, device, say, verify=verify)
    else:
        recorded = existing.engine.get("engine", "jax")
        if engine not in ("auto", recorded):
            raise InputError(
                f"--engine: found {engine}, expected {recorded}, with which {out} was started"
            )
        engine = recorded
    request = described(scenario, runs=runs, seed=seed, engine=engine, device=device, block=block)
    if existing is None and scenario.dispersions:
        from gyrostat.campaigns.draws import check_draws

        check_draws(scenario, seed, runs)
    with store.locked():
        campaign = store.begin(request, force=force)
        refuse_other(campaign.engine, str(out))
        opener, count, fly_job = executor_for(campaign, runs, opener, workers, fly_job)
        damaged = store.check(campaign)
        with kept_open(opener) as pool:
            _fly_blocks(store, campaign, pool, 2 * count + 2, on_progress, say, fly_job)
            store.merge(campaign)
            selection = {*keep, *worst_runs(store, worst, worst_by), *damaged}
            missing = sorted(selection - store.histories(campaign))
            if missing:
                replay(store, campaign, missing, pool, fly_job=fly_job)
    return store.table


def _fly_blocks(store, campaign, opener, window, on_progress, say, fly_job) -> None:
    intact, damaged = store.blocks(campaign)
    for number in damaged:
        say(f"block {number} is damaged or of another campaign; it is simulated again")
    complete_runs = sum(len(campaign.numbers(number)) for number in intact)
    if complete_runs:
        say(f"{complete_runs} of {campaign.runs} runs are already complete")

    def jobs():
        for number in range(campaign.blocks):
            if number not in intact:
                yield Job(campaign, tuple(campaign.numbers(number)), (), number)

    def take(job: Job, results: Any) -> None:
        nonlocal complete_runs
        for path in damaged.get(job.block, ()):
            set_aside(path)
        store.write_block(campaign, job.block, results.columns)
        complete_runs += len(job.runs)
        if on_progress is not None:
            on_progress(complete_runs, campaign.runs)

    if on_progress is not None:
        on_progress(complete_runs, campaign.runs)
    if complete_runs < campaign.runs:
        carry_out(jobs(), fly_job, opener, take, window=window)


def replay(
    store: Store,
    campaign: Campaign,
    runs: Sequence[int],
    opener: Opener,
    fly_job: Callable[[Job], Any] = work,
) -> list[Path]:
    """Repeat runs of a finished campaign and keep their histories.

    Raises:
        InputError: A result differs from the table, even if only in the last bit.
    """
    import numpy as np

    table, paths = store.columns(), []

    def take(job: Job, results: Any) -> None:
        for index, run in enumerate(job.runs):
            scalars = {n: values for n, values in results.columns.items() if values.ndim == 1}
            row = table.row(run)
            for name, values in scalars.items():
                recorded = row[name]
                recorded = np.nan if recorded is None else recorded
                if not np.array_equal(values[index], recorded, equal_nan=True):
                    raise InputError(
                        f"run {run}: found {name} {values[index]!r} in the replay, expected "
                        f"{recorded!r} of the table: software or hardware has changed"
                    )
            paths.append(store.write_history(campaign, run, results.histories.of_run(run)))

    parts = [tuple(runs[k : k + AT_ONCE]) for k in range(0, len(runs), AT_ONCE)]
    jobs = [Job(campaign, part, part, -1, _search_inputs(campaign, store, part)) for part in parts]
    carry_out(jobs, fly_job, opener, take, window=1)
    return paths


def _search_inputs(campaign: Campaign, store: Store, runs: Sequence[int]) -> Any:
    """Values and random keys of runs of a search; None for a campaign."""
    if campaign.search is None:
        return None
    from gyrostat.campaigns.noise import given_of

    return given_of(campaign, store.read_table(), runs)
