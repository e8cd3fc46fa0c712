"""Plans of campaigns against the campaigns: processor time, memory and disk.

python benchmarks/campaign_plan.py [SCENARIO.toml ...] [--runs 1000,10000]

Each plan and each campaign is a process of its own; a first plan compiles. Processor times are
compared, because a time of the clock depends on what else the machine does. Exits with 1 if a
number is wrong by more than 20 %.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "examples"
SCENARIOS = [
    EXAMPLES / "scenarios" / "zero_crossing.toml",
    EXAMPLES / "scenarios" / "nadir_and_slew.toml",
    EXAMPLES / "missions" / "earth_observation" / "mission.toml",
]
ALLOWED = 0.2
WHOLE = """
import resource, sys, time
import gyrostat as gs
gs.campaign(sys.argv[1], int(sys.argv[2]), sys.argv[3])
usage = [resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(*(u.ru_utime + u.ru_stime for u in usage), *(1024 * u.ru_maxrss for u in usage))
"""


def run(*words):
    """Output of a process, and its time, s."""
    environment = {"OPENBLAS_NUM_THREADS": "1", **os.environ}
    begun = time.perf_counter()
    command = [sys.executable, "-c", *map(str, words)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr)
    return done.stdout, time.perf_counter() - begun


def planned(scenario, runs):
    """Plan of a campaign, and the time that it took, s."""
    main = "from gyrostat.cli import main; main()"
    text, wall = run(main, "campaign", scenario, "--runs", runs, "--plan", "--json")
    return json.loads(text), wall


def flown(scenario, runs, workers):
    """The quantities of a plan, of a campaign."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "runs"
        text, wall = run(WHOLE, scenario, runs, folder)
        disk = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    own, ended, memory, of_worker = map(float, text.split())
    if ended < 1.0:  # threads
        workers = 0
    return {
        "core_hours": (own + ended) / 3600.0,
        "memory": memory + workers * of_worker,
        "disk": disk,
        "seconds": wall,
    }


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("scenarios", nargs="*", type=Path, default=SCENARIOS)
    arguments.add_argument("--runs", default="1000,10000")
    options = arguments.parse_args()
    print("| scenario | runs | plan took | processor time, s | memory, MiB | disk, MiB | time, s |")
    print("|---|---|---|---|---|---|---|")
    worst = 0.0
    for scenario in options.scenarios:
        planned(scenario, 64)
        for runs in map(int, options.runs.split(",")):
            plan, took = planned(scenario, runs)
            campaign = flown(scenario, runs, plan["workers"])
            cells = []
            for name, scale in (
                ("core_hours", 3600.0),
                ("memory", 2.0**-20),
                ("disk", 2.0**-20),
                ("seconds", 1.0),
            ):
                ratio = plan[name] / campaign[name]
                if name != "seconds":
                    worst = max(worst, abs(ratio - 1.0))
                found, expected = scale * plan[name], scale * campaign[name]
                cells.append(f"{found:.1f} / {expected:.1f} = {ratio:.2f}")
            row = [scenario.stem, str(runs), f"{took:.0f} s", *cells]
            print("| " + " | ".join(row) + " |", flush=True)
    print(f"largest error: {100.0 * worst:.0f} %")
    sys.exit(worst > ALLOWED)


if __name__ == "__main__":
    main()
