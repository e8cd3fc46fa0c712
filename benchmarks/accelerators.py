"""Runs on an accelerator: steps per second, agreement with the native engine, bits of a replay.

python benchmarks/accelerators.py [--engine cuda] [--scenario zero_crossing] [--runs 65536]
    [--check 10000] [--repeats 3] [--threads 4] [--json FILE]

One step is one integration step of one run. Times include the transfer of the drawn values to the
device, and of metrics and percentiles back; the first, untimed pass compiles.
`native` is one thread of this machine. A run departs from that of the native engine if a count or
its status differs, or a metric by more than 1e-10 of its scale: there a rounding decides an event,
such as whether a wheel sticks.
"""

import argparse
import json
import platform
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from gyrostat.campaigns import run_campaign
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly
from gyrostat.campaigns.ready import make_ready
from gyrostat.codegen.simd.compiler import compiler
from gyrostat.runs.run_loop import Drawn
from gyrostat.scenario.kinds.orbits import own_orbits
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario_files.scenario_file import read_scenario

TOLERANCE = 1e-10
"""Largest difference, in the scale of a metric, of a run in which no rounding decides an event."""
EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"


def compute(ready, runs, seed=1):
    """Compute runs from their draws to the errors and metrics in memory; times of both parts, s."""
    start = time.perf_counter()
    values, keys = draw(ready.scenario, seed, np.asarray(runs))
    drawn = Drawn(values, own_orbits(ready.scenario, values))
    arguments = (ready.nominal, drawn, ready.plans, keys)
    middle = time.perf_counter()
    if not hasattr(ready.program, "concluded"):
        for _ in ready.program.chunks(*arguments, ()):
            pass
    else:
        ready.program.concluded(*arguments, ready.scenario.percentiles)
    return middle - start, time.perf_counter() - middle


def steps_of(scenario):
    """Integration steps of one run."""
    return scenario.count * structure_of(scenario).substeps


def measure(ready, steps, runs, repeats, threads):
    """Steps per second of blocks of runs: one after the other, and in threads."""
    compute(ready, range(runs))
    single = min(compute(ready, range(runs))[1] for _ in range(repeats))
    blocks = [range(k * runs, (k + 1) * runs) for k in range(repeats * threads)]
    with ThreadPoolExecutor(threads) as pool:
        list(pool.map(lambda block: compute(ready, block), blocks[:threads]))
        start = time.perf_counter()
        list(pool.map(lambda block: compute(ready, block), blocks))
        together = time.perf_counter() - start
    return {
        "runs": runs,
        "steps_per_s": runs * steps / single,
        "threads": threads,
        "steps_per_s_in_threads": len(blocks) * runs * steps / together,
    }


def whole(scenario, engine, steps, runs, threads, block):
    """Steps per second of a campaign, from the draws to its table of runs."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        options = {"engine": engine, "workers": threads, "block": block, "worst": 0}
        run_campaign(scenario, Path(folder) / "out", runs=runs, seed=2, **options)
        return runs * steps / (time.perf_counter() - start)


def columns_of(scenario, engine, runs, block=2048):
    """Columns of runs with several blocks."""
    parts = [
        fly(scenario, 1, range(k, min(k + block, runs)), engine=engine).columns
        for k in range(0, runs, block)
    ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def compare(columns, reference):
    """Runs that depart from those of the native engine, and the largest differences of the others.

    The scale of a metric is its largest value in all runs; that of a pointing error is the largest
    pointing error.
    """
    largest = np.nanmax(reference["error_max"])
    differences, departed = {}, np.zeros(len(columns["run"]), bool)
    for name, values in columns.items():
        expected = reference[name]
        if values.ndim > 1:  # of the first runs only
            continue
        if values.dtype.kind != "f":
            departed |= values != expected
            continue
        finite = np.abs(expected[np.isfinite(expected)])
        scale = largest if "error_" in name else max(finite, default=0.0)
        departed |= np.isnan(values) != np.isnan(expected)
        differences[name] = np.nan_to_num(np.abs(values - expected)) / (scale or 1.0)
    for difference in differences.values():
        departed |= difference > TOLERANCE
    worst = {name: float(each[~departed].max()) for name, each in differences.items()}
    listed = np.flatnonzero(departed).tolist()
    ordered = sorted(worst.items(), key=lambda item: -item[1])
    return {"departed": len(listed), "first of them": listed[:20], "largest": dict(ordered[:5])}


def main():
    """Print the results."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--engine", default="cuda")
    arguments.add_argument("--scenario", default="zero_crossing")
    arguments.add_argument("--runs", type=int, nargs="+", default=[65536])
    arguments.add_argument("--check", type=int, default=10_000)
    arguments.add_argument("--whole", type=int, default=0, help="runs of a campaign")
    arguments.add_argument("--block", type=int, default=16384)
    arguments.add_argument("--repeats", type=int, default=3)
    arguments.add_argument("--threads", type=int, default=4)
    arguments.add_argument("--reference", type=Path, help="npz file with columns of native runs")
    arguments.add_argument("--json", type=Path)
    options = arguments.parse_args()
    scenario = read_scenario(EXAMPLES / f"{options.scenario}.toml")
    steps = steps_of(scenario)
    result = {"scenario": options.scenario, "steps": steps, "machine": platform.processor()}

    def say(name, value):
        result[name] = value
        print(f"{name}: {json.dumps(value)}", flush=True)
        if options.json:
            options.json.write_text(json.dumps(result, indent=1))

    start = time.perf_counter()
    ready = make_ready(scenario, options.engine)
    say("device", ready.program.program.device.name)
    say("seconds to the first program", round(time.perf_counter() - start, 1))
    begin, chunk = ready.program.program.kernels()
    say("begin", begin.usage.text())
    say("chunk", chunk.usage.text())
    for runs in options.runs:
        say(f"{runs} runs", measure(ready, steps, runs, options.repeats, options.threads))
    if compiler():
        native = make_ready(scenario, "native")
        compute(native, range(1024))
        seconds = min(compute(native, range(1024))[1] for _ in range(options.repeats))
        say("native steps per s, one thread", 1024 * steps / seconds)
    if options.check:
        columns = columns_of(scenario, options.engine, options.check)
        picked = [1, options.check // 2, options.check - 1]
        again = fly(scenario, 1, picked, engine=options.engine, keep=picked[:1]).columns
        same = all(np.array_equal(v, columns[n][picked], equal_nan=True) for n, v in again.items())
        say("replay has the same bits", same)
        if options.reference and options.reference.exists():
            with np.load(options.reference) as stored:
                reference = {name: stored[name][: options.check] for name in stored.files}
        else:
            reference = columns_of(scenario, "native", options.check)
            if options.reference:
                np.savez(options.reference, **reference)
        say(f"{options.check} runs against native", compare(columns, reference))
    if options.whole:
        rate = whole(scenario, options.engine, steps, options.whole, options.threads, options.block)
        say("steps per s of a campaign", rate)


if __name__ == "__main__":
    main()
