"""A campaign of ten million runs: memory and time of everything except the simulation.

python benchmarks/large_campaign.py [--runs 10000000] [--folder DIR]

64 runs of `zero_crossing.toml` are simulated; the blocks of all runs imitate them, with draws of
their own. Then, each in a process of its own: the command, which finds all blocks and writes table,
statistics and report; the report again; a mean of one column in Python; and the command without a
twentieth of the blocks, as after a kill, until it simulates.
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SCENARIO = Path(__file__).parents[1] / "examples" / "scenarios" / "zero_crossing.toml"
MEASURED = """
import json, resource, sys, time
begun = time.perf_counter()
{code}
own = resource.getrusage(resource.RUSAGE_SELF)
times = {{"wall": time.perf_counter() - begun, "processor": own.ru_utime + own.ru_stime}}
print(json.dumps({{**times, "memory": own.ru_maxrss / 1024.0}}))
"""
COMMAND = """
import gyrostat as gs
gs.campaign(sys.argv[1], int(sys.argv[2]), sys.argv[3], worst=0)
"""
REPORT = """
import gyrostat as gs
gs.report(sys.argv[3])
"""
RESUME = """
import gyrostat as gs
class Resumed(Exception):
    pass
def on_progress(done, total):
    raise Resumed
try:
    gs.campaign(sys.argv[1], int(sys.argv[2]), sys.argv[3], on_progress=on_progress)
except Resumed:
    pass
"""
MEAN = """
from gyrostat.campaigns import campaign_runs
campaign_runs(sys.argv[3])["error_max"].mean().item()
"""


def imitate(runs, folder):
    """Write the blocks of a campaign, and no table."""
    from gyrostat.campaigns import Store
    from gyrostat.campaigns.engine import fly
    from gyrostat.campaigns.execute import chosen_engine, described
    from gyrostat.campaigns.imitation import write_imitation
    from gyrostat.scenario_files.scenario_file import read_scenario

    scenario = read_scenario(SCENARIO)
    engine = chosen_engine("auto", scenario, "cpu")
    columns = fly(scenario, 0, range(64), engine=engine).columns
    store = Store(folder)
    campaign = described(scenario, runs=runs, seed=0, engine=engine)
    with store.locked():
        write_imitation(store, scenario, campaign, columns)


def row(name, code, runs, folder):
    """Print the time and memory of some code in a process of its own."""
    command = [sys.executable, "-c", MEASURED.format(code=code), SCENARIO, str(runs), folder]
    environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    spent = json.loads(done.stdout.splitlines()[-1])
    cells = [f"{spent[k]:.1f} s" for k in ("wall", "processor")] + [f"{spent['memory']:.0f} MiB"]
    print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=10_000_000)
    arguments.add_argument("--folder", type=Path, help="kept, and used again")
    options = arguments.parse_args()
    folder = options.folder or Path(tempfile.mkdtemp()) / "runs"
    try:
        if not (folder / "campaign.json").exists():
            begun = time.perf_counter()
            imitate(options.runs, folder)
            print(f"blocks written in {time.perf_counter() - begun:.0f} s")
        print(f"{options.runs} runs")
        print("| what | time | processor time | memory |", "|---|---|---|---|", sep="\n")
        row("table, statistics and report, after the last block", COMMAND, options.runs, folder)
        row("report again", REPORT, options.runs, folder)
        row("mean of one column", MEAN, options.runs, folder)
        for path in sorted((folder / "blocks").iterdir())[::20]:
            path.unlink()
        row("resumed, until it simulates", RESUME, options.runs, folder)
    finally:
        if options.folder is None:
            shutil.rmtree(folder.parent)


if __name__ == "__main__":
    main()
