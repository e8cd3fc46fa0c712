"""Plan of a campaign: time, memory and disk that it will take, estimated from 64 of its runs."""

import json
import math
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.core.processors import usable_cores
from gyrostat.verbs.arguments import Say

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.scenario import Scenario

QUANTITIES = {
    "seconds": ("s", "Time of the command on this machine, as busy as it is now."),
    "core_hours": ("h", "Processor time of the command and its workers."),
    "memory": ("bytes", "Largest memory of the command and its workers together."),
    "command_memory": ("bytes", "Largest memory of the command."),
    "worker_memory": ("bytes", "Largest memory of a worker process; 0 for threads."),
    "disk": ("bytes", "Size of all files of the folder."),
    "workers": ("", "Number of workers."),
}
"""Quantities of a plan -> unit and meaning."""
_CODE = "from gyrostat.verbs.plan_measurements import main; main()"


def campaign_plan(
    scenario: "Scenario",
    runs: int,
    seed: int,
    *,
    engine: str,
    workers: int | None,
    block: int | None,
    say: Say,
) -> "xr.Dataset":
    """Estimate what a campaign takes; nothing is written to the current folder.

    Args:
        scenario: Scenario with dispersions.
        runs: Number of runs of the campaign.
        seed: Seed of the draws.
        engine: "native", "jax" or "auto".
        workers: Number of worker processes, or None.
        block: Number of runs in a block, or None.
        say: Function that receives each message for the user.

    Returns:
        A dataset with one number for each of `QUANTITIES`.

    Raises:
        InputError: The engine cannot simulate the scenario, or the runs fail.
    """
    import xarray as xr

    from gyrostat.campaigns.execute import MOST_RUNS, chosen_engine
    from gyrostat.core.validation import check_seed

    check_seed(seed)
    if not 1 <= runs <= MOST_RUNS:
        raise InputError(f"runs: found {runs}, expected 1 to {MOST_RUNS}")
    engine = chosen_engine(engine, scenario, "cpu", say)
    request = {"text": scenario.text(), "runs": runs, "seed": seed, "engine": engine}
    numbers = estimate(measured({**request, "workers": workers, "block": block}), runs)
    variables = {
        name: ((), numbers[name], {"units": unit, "long_name": meaning})
        for name, (unit, meaning) in QUANTITIES.items()
    }
    about = {"scenario": scenario.name, "runs": runs, "seed": seed, "engine": engine}
    plan = xr.Dataset(variables, attrs=about)
    for line in plan_lines(plan_content(plan)):
        say(line)
    return plan


def measured(request: Mapping[str, Any]) -> dict[str, Any]:
    """Measurements of `gyrostat.verbs.plan_measurements` in a process of its own.

    Args:
        request: Arguments by name: text of the scenario, runs, seed, engine, workers, block.

    Raises:
        InputError: The process failed.
    """
    done = subprocess.run(
        [sys.executable, "-c", _CODE],
        input=json.dumps({**request, "begun": time.time()}),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise InputError(f"--plan: found runs that fail ({last}), expected 64 complete runs")
    return json.loads(done.stdout.splitlines()[-1])


def estimate(measurements: Mapping[str, Any], runs: int) -> dict[str, float]:
    """Quantities of the plan of a campaign.

    A campaign of 64 runs is measured as a whole. Each further run adds its simulation, its draws
    and its share of a block; the tables of runs give what the number of runs adds to table,
    statistics and report.

    Args:
        measurements: See `measured`.
        runs: Number of runs.
    """
    m, pace, whole, tables = (measurements, *(measurements[k] for k in ("pace", "whole", "tables")))
    blocks = math.ceil(runs / m["block"])
    workers = min(m["workers"], blocks)
    further, jobs = max(runs - m["few"], 0), blocks - 1
    write = _at(tables, "write", runs) - tables[0]["write"]
    here = write + jobs * pace["job"]
    flights = further * pace["processor"]
    late = {k: _at(tables, k, runs) - tables[0][k] for k in ("wall", "processor")}
    draws = further * m["draws"]
    starts = max(workers - 1, 0) * pace["start"]
    processor = whole["processor"] + flights + here + late["processor"] + draws + starts
    together = max(further * pace["wall"] / workers, (flights + here) / usable_cores(), here)
    command = max(whole["memory"], pace["memory_here"], _at(tables, "memory", runs))
    worker = 0.0 if m["in_threads"] else pace["memory"]
    return {
        "seconds": whole["wall"] + together + late["wall"] + draws,
        "core_hours": processor / 3600.0,
        "memory": command + workers * worker,
        "command_memory": command,
        "worker_memory": worker,
        "disk": whole["disk"] + _at(tables, "disk", runs) - tables[0]["disk"],
        "workers": workers,
    }


def _at(tables: Sequence[Mapping[str, float]], name: str, runs: int) -> float:
    """Value for a number of runs, by straight lines through the tables of runs."""
    if len(tables) == 1:
        return tables[0][name]
    upper = next((k for k, t in enumerate(tables) if k > 0 and runs <= t["runs"]), len(tables) - 1)
    low, high = tables[upper - 1], tables[upper]
    slope = (high[name] - low[name]) / (high["runs"] - low["runs"])
    return low[name] + slope * (runs - low["runs"])


def plan_content(plan: "xr.Dataset") -> dict[str, Any]:
    """Plan as JSON content."""
    numbers = {name: plan[name].item() for name in QUANTITIES}
    units = {name: unit for name, (unit, _) in QUANTITIES.items()}
    return {**plan.attrs, **numbers, "units": units}


def plan_lines(content: Mapping[str, Any]) -> list[str]:
    """Plan as lines for a terminal."""
    of_worker = content["worker_memory"]
    workers = int(content["workers"])
    parts = f"{workers} threads of one process"
    if of_worker > 0.0:
        parts = (
            f"{_binary(content['command_memory'])} for the command, {_binary(of_worker)} for each "
            f"of {workers} workers"
        )
    return [
        f"{content['runs']} runs of {content['scenario']}, engine {content['engine']}:",
        f"  time: {_duration(content['seconds'])} on this machine, as busy as it is now",
        f"  processor time: {content['core_hours']:.3g} core-hours",
        f"  memory: {_binary(content['memory'])} ({parts})",
        f"  disk: {_binary(content['disk'])}",
    ]


def _duration(seconds: float) -> str:
    """Time with its unit."""
    for unit, size in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def _binary(size: float) -> str:
    """Size in MiB or GiB."""
    return f"{size / 2.0**30:.3g} GiB" if size >= 2.0**30 else f"{size / 2.0**20:.3g} MiB"
