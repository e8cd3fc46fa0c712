"""Measurements for the plan of a campaign, in a process of their own: its memory is measured too.

The process carries out a campaign of 64 runs, simulates these runs again until all workers have
their steady pace, and makes reports of tables that imitate more runs.
"""

import json
import os
import resource
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from gyrostat.campaigns import Campaign, Job
    from gyrostat.campaigns.executors import Opener
    from gyrostat.core.types import Vector
    from gyrostat.scenario import Scenario

FEW = 64
"""Number of runs that are simulated."""
SIZES = (20_000, 100_000)
"""Numbers of runs of the tables whose reports are made, beside that of 64 runs."""
_STEADY = 2.0
"""Least time during which all workers simulate, s."""
_DRAWN = 65_536
"""Largest number of runs whose draws are validated."""


class Spent(NamedTuple):
    """Time and memory up to a moment.

    Attributes:
        wall: Time, s.
        processor: Processor time of this process and of its ended workers, s.
        memory: Largest memory of this process so far, bytes.
    """

    wall: float
    processor: float
    memory: float

    @classmethod
    def now(cls) -> "Spent":
        """Present values."""
        usage = [resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        processor = sum(each.ru_utime + each.ru_stime for each in usage)
        return cls(time.time(), processor, _bytes(usage[0].ru_maxrss))

    def since(self, start: "Spent") -> dict[str, float]:
        """Time since another moment, and the memory, by name."""
        wall, processor = self.wall - start.wall, self.processor - start.processor
        return {"wall": wall, "processor": processor, "memory": self.memory}


class TimedWork(NamedTuple):
    """Work of a worker that measures its time and memory.

    Attributes:
        work: Function that simulates the runs of a job.
        in_threads: Whether the workers are threads of one process.
    """

    work: "Callable[[Job], Any]"
    in_threads: bool

    def __call__(self, job: "Job") -> "tuple[dict[str, Vector], dict[str, float]]":
        """Simulate the runs of a job; returns columns, and times, s, and memory, bytes."""
        clock = time.thread_time if self.in_threads else time.process_time
        begun, used = time.perf_counter(), clock()
        columns = self.work(job).columns
        return columns, {
            "worker": threading.get_ident() if self.in_threads else os.getpid(),
            "wall": time.perf_counter() - begun,
            "processor": clock() - used,
            "before": used,
            "memory": _bytes(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss),
        }


def main() -> None:
    """Measure what the request on the standard input describes; print the result as JSON."""
    request = json.load(sys.stdin)
    with tempfile.TemporaryDirectory(prefix="gyrostat-plan-") as name:
        content = _measured(Path(name), **request)
    print(json.dumps(content))


def _measured(
    folder: Path,
    text: str,
    runs: int,
    seed: int,
    engine: str,
    workers: int | None,
    block: int | None,
    begun: float,
) -> dict[str, Any]:
    """Measurements by name; `begun` is the time at which the process was started, s."""
    from gyrostat import verbs
    from gyrostat.campaigns.execute import described
    from gyrostat.campaigns.jobs import executor_for, work_here
    from gyrostat.scenario import Scenario

    scenario = Scenario.from_text(text)
    few = described(scenario, runs=min(runs, FEW), seed=seed, engine=engine)
    many = described(scenario, runs=runs, seed=seed, engine=engine, block=block)
    opener, count, work = executor_for(many, runs, None, workers)
    in_threads = work is work_here
    first = folder / "first"
    pool = None if in_threads else count
    verbs.campaign(scenario, few.runs, first, seed=seed, engine=engine, workers=pool)
    whole = Spent.now().since(Spent(begun, 0.0, 0.0))
    count = min(count, many.blocks)
    columns, pace = pace_of(few, opener, count, TimedWork(work, in_threads))
    return {
        "few": few.runs,
        "block": many.block,
        "workers": count,
        "in_threads": in_threads,
        "whole": {**whole, "disk": _size(first)},
        "pace": pace,
        "draws": _draws(scenario, seed, min(runs, _DRAWN)),
        "tables": tables_of(folder, scenario, many, columns),
    }


def pace_of(
    few: "Campaign", opener: "Opener", count: int, work: TimedWork
) -> "tuple[dict[str, Vector], dict[str, float]]":
    """Columns of the few runs, and times of their simulation while all workers are busy.

    The first job of each worker loads the program and is left out.
    """
    from gyrostat.campaigns.executors import carry_out
    from gyrostat.campaigns.jobs import Job

    job = Job(few, tuple(range(few.runs)), (), 0)
    results: list[Any] = []
    moments: list[tuple[float, float]] = []

    def jobs() -> "Iterator[Job]":
        given = 0
        while given < 4 * count or time.perf_counter() - moments[0][0] < _STEADY:
            given += 1
            yield job

    def take(_: "Job", result: Any) -> None:
        moments.append((time.perf_counter(), time.process_time()))
        results.append(result)

    carry_out(jobs(), work, opener, take, window=2 * count)
    columns, times = results[0][0], [each for _, each in results]
    known: set[float] = set()
    warm, cold = [], []
    for each in times:
        (warm if each["worker"] in known else cold).append(each)
        known.add(each["worker"])
    runs = few.runs
    pace = {name: sum(t[name] for t in warm) / len(warm) / runs for name in ("wall", "processor")}
    here = (moments[-1][1] - moments[0][1]) / (len(moments) - 1)
    extra = [t["before"] + t["processor"] - runs * pace["processor"] for t in cold]
    return columns, {
        **pace,
        "job": max(here - (runs * pace["processor"] if work.in_threads else 0.0), 0.0),
        "start": 0.0 if work.in_threads else sum(extra) / len(extra),
        "memory": max(each["memory"] for each in times),
        "memory_here": Spent.now().memory,
    }


def _draws(scenario: "Scenario", seed: int, runs: int) -> float:
    """Processor time of the validation of the drawn values of a run, s."""
    from gyrostat.campaigns.draws import check_draws

    start = Spent.now()
    check_draws(scenario, seed, runs)
    return (Spent.now().processor - start.processor) / runs


def tables_of(
    folder: Path, scenario: "Scenario", many: "Campaign", columns: "Mapping[str, Vector]"
) -> list[dict[str, float]]:
    """Time, memory and size of files of tables of several sizes, up to that of the campaign."""
    from dataclasses import replace

    from gyrostat.campaigns import Store, campaign_runs, worst_runs
    from gyrostat.campaigns.imitation import write_imitation
    from gyrostat.reports.campaign import write_campaign
    from gyrostat.scenario.metrics.results import percentile_name

    tables = []
    for runs in sorted({min(many.runs, size) for size in (FEW, *SIZES)}):
        campaign, store = replace(many, runs=runs), Store(folder / f"{runs}")
        with store.locked():
            write = write_imitation(store, scenario, campaign, columns)
            start = Spent.now()
            store.merge(campaign)
            worst_runs(store, 1, percentile_name(scenario.percentiles[-1]))
        write_campaign(store.folder, command="gyrostat campaign", say=lambda text: None)
        campaign_runs(store.folder)
        spent = Spent.now().since(start)
        disk = _size(store.folder)
        tables.append({"runs": runs, "write": write, "disk": disk, **spent})
    return tables


def _size(folder: Path) -> int:
    """Size of all files in a folder, bytes."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _bytes(maximum: int) -> float:
    """Memory in bytes; Linux counts it in KiB."""
    return float(maximum if sys.platform == "darwin" else 1024 * maximum)
