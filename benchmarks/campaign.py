"""Campaigns of many runs: runs and steps per second, and peak memory against the number of runs.

python benchmarks/campaign.py [--runs 20000] [--duration 40] [--period 0.25] [--engine lanes]

The cubesat of `zero_crossing_model.toml`. Each campaign is a process of its own, so that
peaks are its own; the first, a short one, compiles.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"


def fly(runs, duration, period, engine, workers):
    """Fly a campaign in this process; its time, s, and peaks of memory, MiB."""
    from gyrostat.campaigns import run_campaign
    from gyrostat.scenario_files.scenario_file import read_scenario

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in ("cubesat.toml", "cubesat_wheel.toml"):
            (folder / file).write_text((EXAMPLES / file).read_text())
        text = (EXAMPLES / "zero_crossing_model.toml").read_text()
        text = text.replace('"400 s"', str(duration)).replace('after = "60 s"', 'after = "20 s"')
        text = text.replace('control_period = "0.25 s"', f"control_period = {period}")
        (folder / "scenario.toml").write_text(text)
        scenario = read_scenario(folder / "scenario.toml")
        begun = []

        def told(done, total):
            begun.append((time.perf_counter(), done))

        run_campaign(
            scenario,
            folder / "out",
            runs=runs,
            engine=engine,
            workers=workers,
            worst=0,
            on_progress=told,
        )
        # from the first block on: before it, workers start and load their program
        (first, before), (last, after) = begun[workers], begun[-1]
        peaks = [
            resource.getrusage(who).ru_maxrss / 1024.0
            for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        ]
        rate = (after - before) / max(last - first, 1e-9)
        return {
            "rate": rate,
            "steps": rate * scenario.count,
            "parent": peaks[0],
            "worker": peaks[1],
        }


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=20_000)
    arguments.add_argument("--duration", type=float, default=40.0)
    arguments.add_argument("--period", type=float, default=0.25, help="of control, s")
    arguments.add_argument("--engine", default="auto")
    arguments.add_argument("--workers", type=int, default=2)
    arguments.add_argument("--one", type=int, help="only this campaign, its numbers as JSON")
    options = arguments.parse_args()
    if options.one:
        how = (options.duration, options.period, options.engine, options.workers)
        print(json.dumps(fly(options.one, *how)))
        return
    with tempfile.TemporaryDirectory() as cache:
        environment = {
            "JAX_COMPILATION_CACHE_DIR": cache,
            "GYROSTAT_CACHE": cache,
            "JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS": "0.05",
            **os.environ,
        }
        print("| runs | runs/s | control periods/s | peak of parent | of a worker |")
        print("|---|---|---|---|---|")
        peaks = []
        for runs in (2 * 64 * options.workers, max(options.runs // 20, 640), options.runs):
            command = [sys.executable, __file__, "--one", str(runs)]
            for name in ("duration", "period", "engine", "workers"):
                command += [f"--{name}", str(getattr(options, name))]
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, check=True
            )
            found = json.loads(done.stdout)
            peaks.append(found["parent"] + options.workers * found["worker"])
            if len(peaks) == 1:
                continue
            print(
                f"| {runs} | {found['rate']:.0f} | {found['steps']:.3g} | "
                f"{found['parent']:.0f} MiB | {found['worker']:.0f} MiB |",
                flush=True,
            )
    print(f"peak memory of {options.runs} runs over that of a twentieth: {peaks[2] / peaks[1]:.2f}")


if __name__ == "__main__":
    main()
