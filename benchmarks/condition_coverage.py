"""Test vectors of exported controllers, and what they show: lines, branches and MC/DC, by clang.

    python benchmarks/condition_coverage.py [NAME ...] [--precision float] [--keep FOLDER]

Prints for each flight module the decisions and conditions of its C code, the number of vectors, the
time of the search and its share of the limit, and of clang's report the lines, branches and
conditions that are not shown and those that are justified. Exits with 1 if something is neither
shown nor justified.
"""

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from calibrating_filter import PERIOD, filtered, sensed
from controller_programs import (
    EXAMPLES,
    HORIZON,
    kalman_filter,
    motions,
    network,
    perceptron,
    predictive,
)
from flight_modules import PARTS, of_scenario

from gyrostat.codegen.tracing import as_arrays
from gyrostat.control import MeasurementGuard
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax
from gyrostat.exports import Search, read_results, targets
from gyrostat.exports.folder import emitted, files_of
from gyrostat.exports.target import STEPS

SCENARIOS = {
    path.stem: path
    for path in (
        *sorted((EXAMPLES / "scenarios").glob("*.toml")),
        EXAMPLES / "missions" / "earth_observation" / "mission.toml",
    )
    if "[controller]" in path.read_text(encoding="utf-8")
}


class Command(NamedTuple):
    """Torques of a user's controller."""

    torque: Any


class Memoryless(eqx.Module):
    """Multilayer perceptron."""

    weights: Any

    def start(self, period):
        """See `Guarded`."""
        return ()

    def __call__(self, memory, measurement):
        """See `Guarded`."""
        return memory, Command(perceptron(self.weights, measurement))


class Predictive(eqx.Module):
    """Model predictive control."""

    horizon: int = eqx.field(static=True, default=HORIZON)

    def start(self, period):
        """See `Guarded`."""
        return np.zeros(3 * self.horizon)

    def __call__(self, memory, measurement):
        """See `Guarded`."""
        plan, torque = predictive(memory, measurement)
        return plan, Command(torque)


class Filter(eqx.Module):
    """Kalman filter of 15 states, with the error that it estimates as the command."""

    gain: float = 0.1

    def start(self, period):
        """See `Guarded`."""
        return kalman_filter().arguments["estimate"]

    def __call__(self, memory, measurement):
        """See `Guarded`."""
        estimate = filtered(memory, measurement)
        return estimate, Command(self.gain * measurement.rate)


def of_user(controller, measured, period=1.0):
    """Flight module of a user's controller."""
    measured = jax.tree.map(lambda leaf: np.asarray(leaf)[:STEPS], measured)
    sample = as_arrays(jax.tree.map(lambda leaf: leaf[0], measured))
    guard = MeasurementGuard.of(sample, {}, "hold")
    return targets.flight_loop("controller", "User", controller, period, guard, measured)


MODULES = {
    **PARTS,
    "mlp": lambda: of_user(Memoryless(network()), motions()),
    "mpc": lambda: of_user(Predictive(), motions()),
    "filter": lambda: of_user(Filter(), sensed(), PERIOD),
    **{name: lambda path=path: of_scenario(path) for name, path in SCENARIOS.items()},
}
"""Name -> flight module."""


def _figures(column):
    suffix = " (MC/DC)" if column == "conditions" else ""
    return f"{column}{suffix}", f"{column} not shown{suffix}"


COLUMNS = ("lines", "branches", "conditions")


def measured(name, precision, folder):
    """Row of the table, and whether all is shown or justified."""
    target = MODULES[name]()
    module = emitted(target, precision)
    notes = []
    began = time.monotonic()
    texts = files_of(target, module, precision, "", Search(notes.append))
    seconds = time.monotonic() - began
    write_texts(folder, texts)
    subprocess.run(["sh", folder / "evidence" / "run.sh", "coverage"], capture_output=True)
    result = next(result for result in read_results(folder) if result.name == "coverage")
    figures = {figure.name: figure.value for figure in result.figures}
    print(f"{name:22s} {len(module.source) // 1024:4d} kB {seconds:6.1f} s ", end="")
    for column in COLUMNS:
        every, missing = (figures.get(text, "-") for text in _figures(column))
        print(f" {every:>5s}/{missing:3s}", end="")
    print(f" {figures.get('justified', '-'):>4s}  {result.outcome} {result.reason}")
    print(f"    {notes[0] if notes else 'no message'}", flush=True)
    return result.outcome == "passed"


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", default=[*MODULES], metavar="NAME")
    parser.add_argument("--precision", choices=["double", "float"], default="double")
    parser.add_argument("--keep", type=Path, help="folder for the flight folders")
    options = parser.parse_args()
    print("module                 text    seconds  lines/missing branches conditions justified")
    good = True
    for name in options.names:
        with tempfile.TemporaryDirectory() as folder:
            good &= measured(name, options.precision, (options.keep or Path(folder)) / name)
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
