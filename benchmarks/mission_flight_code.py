"""The Earth observation mission: its controller as C against the simulated commands.

    python benchmarks/mission_flight_code.py [--seed 2] [--folder DIR] [--run RUN.nc]

Simulates the mission (660 s, one wheel seizes at 400 s), exports its controller as C, and runs the
C step by step with the recorded measurements, from its own initial memory. Every command of the C
is compared with the recorded one; the difference is relative to the limit of the command, for an
estimate to its largest value in the run. Prints the largest difference of every command, its time,
and the time of a step. Exits with 1 if a motor torque or a dipole moment differs by more than
1e-10. --folder and --run take a flight folder and a run that exist. Takes minutes: the simulation
and the C are compiled.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import xarray as xr

import gyrostat as gs
from gyrostat.codegen.flight.measure import FLAGS, OPTIMISATION

MISSION = Path(__file__).parents[1] / "examples" / "missions" / "earth_observation" / "mission.toml"
LARGEST = 1e-10
LIMITS = {"torque": 3.2e-3, "torque_rods": 0.4}
"""Limited command -> its limit, N·m and A·m²."""
PERIOD = 0.25

PROGRAM = """
#include "controller.h"
#include <stdio.h>

int main(void)
{
    OutputFeedback controller;
    MeasurementGuard guard;
    GuardedMemory memory;
    AddedTrackerGyroMeasurement measurement;
    EstimatedGuidedCommand command;
    SampleReport report;
    double given[COUNT_IN];
    int status = controller_parameters(&controller, &guard);
    status |= controller_start(&controller, PERIOD, &memory);
    while (fread(given, sizeof given, 1, stdin) == 1) {
        INPUTS
        status |= controller_step(&controller, &guard, &memory, &measurement, &command, &report);
        status |= report.sample_status != 0;
        const double made[COUNT_OUT] = {OUTPUTS};
        fwrite(made, sizeof made, 1, stdout);
    }
    return status;
}
"""


def column(run, prefix, place):
    """Recorded values of a scalar of C, such as attitude[2]; only a repeated name has a prefix."""
    name, *index = re.findall(r"\w+", place)
    label = f"{prefix}_{name}"
    values = np.asarray(run[label if label in run else name], dtype=float)
    return values[(slice(None), *map(int, index))]


def flown(folder, measured):
    """Commands of the C for measurements: name in C -> values; and the time of a step, s."""
    test = (folder / "controller_test.c").read_text(encoding="utf-8")
    inputs = re.findall(r"measurement\.(\S+) = given", test)
    outputs = re.findall(r"\(double\)\(command\.(\S+)\),", test)
    text = PROGRAM.replace("COUNT_IN", str(len(inputs))).replace("COUNT_OUT", str(len(outputs)))
    lines = [f"measurement.{place} = given[{k}];" for k, place in enumerate(inputs)]
    text = text.replace("INPUTS", "\n        ".join(lines)).replace("PERIOD", str(PERIOD))
    text = text.replace("OUTPUTS", ", ".join(f"command.{place}" for place in outputs))
    rows = np.stack([column(measured, "measured", place) for place in inputs], axis=1)
    with tempfile.TemporaryDirectory() as made:
        main, program = Path(made) / "main.c", Path(made) / "program"
        main.write_text(text, encoding="utf-8")
        sources = [str(main), str(folder / "controller.c"), f"-I{folder}"]
        words = ["cc", *FLAGS.split(), OPTIMISATION, *sources, "-lm", "-o", str(program)]
        subprocess.run(words, check=True)
        begun = time.perf_counter()
        done = subprocess.run([program], input=rows.tobytes(), stdout=subprocess.PIPE, check=True)
        taken = time.perf_counter() - begun
    commands = np.frombuffer(done.stdout).reshape(-1, len(outputs))
    return dict(zip(outputs, commands.T, strict=True)), taken / len(commands)


def main():
    """Simulate, export, run and compare."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seed", type=int, default=2)
    parser.add_argument("--folder", type=Path, help="flight folder of the mission's controller")
    parser.add_argument("--run", type=Path, help="run of the mission, netCDF")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = chosen.folder or Path(made) / "flight"
        if chosen.folder is None:
            gs.export(MISSION, folder, to="c")
        run = xr.load_dataset(chosen.run) if chosen.run else gs.simulate(MISSION, seed=chosen.seed)
        commands, step = flown(folder, run)
    recorded = {place: column(run, "commanded", place) for place in commands}
    largest = {}
    for place, values in recorded.items():
        name = place.partition("[")[0]
        largest[name] = max(largest.get(name, 0.0), np.max(np.abs(values)))
    compared = {}
    for place, values in commands.items():
        name = place.partition("[")[0]
        error = np.abs(values - recorded[place]) / LIMITS.get(name, largest[name] or 1.0)
        error = np.where(np.isnan(error), np.inf, error)
        k = int(np.argmax(error))
        compared.setdefault(name, []).append((error[k], float(run["time"][k]), place))
    for name, found in compared.items():
        error, when, place = max(found)
        print(f"{name}: {error:.1e} at {when:g} s ({place})")
    worst = max(error for name in LIMITS for error, _, _ in compared[name])
    print(f"{len(run['time'])} steps, {1e6 * step:.0f} µs a step")
    print(f"commands: largest difference {worst:.1e} of their limits, expected {LARGEST:g}")
    sys.exit(not worst <= LARGEST)


if __name__ == "__main__":
    main()
