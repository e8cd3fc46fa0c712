"""Campaigns with bristle friction: rate of the native engine over that with Stribeck friction.

    python benchmarks/bristle_campaign.py [--runs 256] [--repeats 3]

The cubesat of `zero_crossing_model.toml`, 400 s, four wheels that go through zero speed
slowly, on one core. Both programs run in turns in one process, and the shortest processor time of
each counts. The bristles bend by 0.01 or 0.001 rad under the Coulomb torque, with a damping ratio
of 0.3, or of 0.0005, at which they ring.
"""

import argparse
import tempfile
import time
from pathlib import Path

from gyrostat.campaigns.engine import fly
from gyrostat.scenario_files.scenario_file import read_scenario

EXAMPLES = Path(__file__).parents[1] / "examples" / "scenarios"
COULOMB, ROTOR = 2e-5, 2e-5
"""Of examples/scenarios/cubesat_wheel.toml, N·m and kg·m²."""


def scenario(bend=None, ratio=None):
    """The example, with bristles of a deflection, rad, and damping ratio, or as it is."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in ("cubesat.toml", "cubesat_wheel.toml", "zero_crossing_model.toml"):
            (folder / file).write_text((EXAMPLES / file).read_text())
        if bend is not None:
            wheel = folder / "cubesat_wheel.toml"
            stiffness = COULOMB / bend
            damping = 2.0 * ratio * (stiffness * ROTOR) ** 0.5
            text = wheel.read_text().replace('"stribeck"', '"lugre"')
            wheel.write_text(f"{text}stiffness = {stiffness}\ndamping = {damping}\n")
        return read_scenario(folder / "zero_crossing_model.toml")


def elapsed(flown, runs):
    """Processor time of runs, s."""
    before = time.process_time()
    fly(flown, 0, range(runs), engine="native")
    return time.process_time() - before


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=256)
    arguments.add_argument("--repeats", type=int, default=3)
    options = arguments.parse_args()
    cases = {
        "Stribeck": scenario(),
        "LuGre, 0.01 rad, damping ratio 0.3": scenario(1e-2, 0.3),
        "LuGre, 0.001 rad, damping ratio 0.3": scenario(1e-3, 0.3),
        "LuGre, 0.01 rad, damping ratio 0.0005": scenario(1e-2, 5e-4),
    }
    for each in cases.values():
        fly(each, 0, range(4), engine="native")  # traces and compiles, or loads
    times = {name: [] for name in cases}
    for _ in range(options.repeats):
        for name, each in cases.items():
            times[name].append(elapsed(each, options.runs))
    print("| friction | runs/s | over Stribeck |\n|---|---|---|")
    first = min(times["Stribeck"])
    for name, found in times.items():
        print(f"| {name} | {options.runs / min(found):.0f} | {first / min(found):.2f} |")


if __name__ == "__main__":
    main()
