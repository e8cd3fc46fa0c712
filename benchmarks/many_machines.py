"""Campaigns on 1, 2, 4 and 8 workers of Dask that share no disk: efficiency and overhead.

    python benchmarks/many_machines.py [--runs 100000] [--workers 1,2,4,8] [--scenario FILE]

Each worker is a process with one thread, a folder and a cache of its own. The machine may have
fewer cores than workers, and other work: times are those that the processors spent (user, system).

    efficiency   processor time of the workers for a run, on one worker over that on n workers,
                 without what they take while idle
    overhead     processor time of the scheduler, beyond what it takes while idle, and of the
                 placement of jobs in the command, over that of the workers
"""

import argparse
import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
SCENARIO = ROOT / "examples" / "scenarios" / "zero_crossing_model.toml"
COMMAND = "from gyrostat.cli import main; main()"
PAUSE = 0.029  # 64 runs of the scenario
IDLE = 10.0  # s
TICKS = os.sysconf("SC_CLK_TCK")


def processor_time(process: int) -> float:
    """User and system time of a process and of its children that have ended, s."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, fields[11:15])) / TICKS


@contextlib.contextmanager
def started(folder: Path, kind: str, *options: str):
    """Scheduler or worker as a process with a folder of its own."""
    folder.mkdir(parents=True)
    names = {"HOME": str(folder), "GYROSTAT_CACHE": str(folder / "cache"), "OMP_NUM_THREADS": "1"}
    with (folder / "log.txt").open("w") as log:
        process = subprocess.Popen(
            [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--host", "127.0.0.1", *options],
            env={**os.environ, **names},
            cwd=folder,
            stdout=log,
            stderr=log,
        )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()


def campaign(scenario: Path, runs: int, out: Path, *options: str) -> dict[str, float]:
    """Wall and processor time of a command, s; of its children too."""
    words = ["campaign", str(scenario), "--runs", str(runs), "--seed", "1", "--out", str(out)]
    before, began = os.times(), time.monotonic()
    subprocess.run(
        [sys.executable, "-c", COMMAND, *words, "--worst", "0", *options],
        check=True,
        stderr=subprocess.DEVNULL,
    )
    after = os.times()
    spent = after.children_user + after.children_system
    spent -= before.children_user + before.children_system
    return {"wall": time.monotonic() - began, "command": spent}


def address_in(file: Path, scheduler: subprocess.Popen) -> str:
    """Address that a scheduler writes to its file, which has no content at first."""
    for _ in range(600):
        with contextlib.suppress(FileNotFoundError, json.JSONDecodeError):
            return json.loads(file.read_text())["address"]
        assert scheduler.poll() is None, "the scheduler ended"
        time.sleep(0.05)
    raise AssertionError("the scheduler has not started")


@contextlib.contextmanager
def on_machines(folder: Path, count: int):
    """Scheduler, workers and address."""
    file = folder / "scheduler.json"
    options = ("--port", "0", "--no-dashboard", "--scheduler-file", str(file))
    with contextlib.ExitStack() as stack:
        scheduler = stack.enter_context(started(folder / "scheduler", "scheduler", *options))
        address = address_in(file, scheduler)
        one = (address, "--no-nanny", "--nthreads", "1", "--no-dashboard")
        workers = [
            stack.enter_context(started(folder / f"worker-{k}", "worker", *one))
            for k in range(count)
        ]
        yield scheduler, workers, address


def on_workers(count: int, folder: Path, scenario: Path, runs: int) -> dict[str, float]:
    """Times of a campaign on a number of workers."""
    with on_machines(folder, count) as (scheduler, workers, address):
        # the first runs of a worker load libraries and the program
        more = "--scheduler", address
        campaign(scenario, 1024 * count, folder / "warm", *more)
        processes = [scheduler.pid, *(worker.pid for worker in workers)]
        idle = sum(map(processor_time, processes[1:]))
        time.sleep(IDLE)
        idle = (sum(map(processor_time, processes[1:])) - idle) / IDLE
        before = [processor_time(each) for each in processes]
        times = campaign(scenario, runs, folder / "out", *more)
        after = [processor_time(each) for each in processes]
    spent = [b - a for a, b in zip(before, after, strict=True)]
    working = sum(spent[1:]) - idle * times["wall"]
    return {**times, "scheduler": spent[0], "workers": working, "idle": idle / count}


def pause(job: int):
    """Job that takes no processor time, with a result of the size of 64 runs."""
    from gyrostat.campaigns.flown import Flown

    time.sleep(PAUSE)
    return Flown({f"column {k}": np.full(64, float(job)) for k in range(45)}, None)


def overhead(folder: Path, runs: int, count: int) -> tuple[int, float, float]:
    """Number of jobs, and processor time of scheduler and placement for them, s."""
    from gyrostat.campaigns.cluster import cluster
    from gyrostat.campaigns.executors import carry_out, kept_open
    from gyrostat.campaigns.handshake import handshake

    jobs, spent = -(-runs // 64), {}
    with on_machines(folder, count) as (scheduler, _, address), contextlib.ExitStack() as stack:
        workers = cluster(address, print).with_handshake(handshake())
        opener = stack.enter_context(kept_open(workers))
        for name, number in (("warm", 20), ("idle", 0), ("busy", jobs)):
            before = processor_time(scheduler.pid), time.process_time(), time.monotonic()
            if number:
                carry_out(range(number), pause, opener, lambda *_: None, window=4098)
            else:
                time.sleep(10.0)
            after = processor_time(scheduler.pid), time.process_time(), time.monotonic()
            spent[name] = [b - a for a, b in zip(before, after, strict=True)]
    idle = [each / spent["idle"][2] for each in spent["idle"]]
    busy = [spent["busy"][k] - idle[k] * spent["busy"][2] for k in range(2)]
    print("idle: scheduler {:.3f}, placement {:.3f} of a processor".format(*idle))
    return jobs, *busy


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--workers", default="1,2,4,8")
    parser.add_argument("--scenario", type=Path, default=SCENARIO)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        campaign(given.scenario, 128, folder / "compiled")
        here = campaign(given.scenario, given.runs, folder / "here", "--workers", "2")
        table = (folder / "here" / "runs.parquet").read_bytes()
        total = here["command"]
        print(
            f"{given.runs} runs, 2 local processes: {here['wall']:.1f} s, {total:.1f} s processor"
        )
        print(
            "workers   wall  workers  scheduler  command   runs/s of processor  efficiency   idle"
        )
        first = None
        for count in map(int, given.workers.split(",")):
            times = on_workers(count, folder / f"on-{count}", given.scenario, given.runs)
            same = (folder / f"on-{count}" / "out" / "runs.parquet").read_bytes() == table
            assert same, f"{count} workers gave other bytes"
            rate = given.runs / times["workers"]
            first = first or rate
            print(
                f"{count:7d} {times['wall']:6.1f} {times['workers']:8.1f} "
                f"{times['scheduler']:10.2f} {times['command']:8.1f} {rate:21.0f} "
                f"{rate / first:11.3f} {times['idle']:6.3f}",
                flush=True,
            )
        jobs, scheduler, placement = overhead(folder / "overhead", given.runs, 2)
        share = (scheduler + placement) * first / given.runs
        print(f"{jobs} jobs: scheduler {scheduler:.2f} s, placement {placement:.2f} s,")
        print(f"{100.0 * share:.1f} % of the processor time of {given.runs} runs on one worker")


if __name__ == "__main__":
    main()
