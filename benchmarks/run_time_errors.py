"""Frama-C's proof for each kind of exported flight code, and for controllers of a user.

    python benchmarks/run_time_errors.py [NAME ...] [--limit 3600]

Exports each module, runs `evidence/run.sh run_time_errors` in its folder, and prints the size of
the C, alarms, results proven to be finite of all, statements that the analysis reached of all, and
seconds of processor time. Exits with 1 if one is not proven.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from calibrating_filter import START, Estimate, Sensors, filtered, sensed
from controller_programs import (
    EXAMPLES,
    HORIZON,
    Motion,
    Network,
    motions,
    network,
    perceptron,
    predictive,
)
from flight_modules import PARTS, PERIOD, of_scenario

from gyrostat.control import MeasurementGuard
from gyrostat.core.files import write_texts
from gyrostat.core.jax64 import jax, jnp
from gyrostat.exports import files, read_results, targets
from gyrostat.exports.target import STEPS

SCENARIOS = (
    *("own_controller", "wheel_failure", "carrara_kuga", "moreira_lopes_kuga"),
    *("endo_sekiguchi_nonaka", "zero_crossing", "zero_crossing_model", "stiff_wheel"),
    *("wheel_array", "nadir_and_slew", "carvalho_fenili", "wheel_failure_found"),
)


class Torque(NamedTuple):
    """Command, N·m."""

    torque: Any


class Perceptron(eqx.Module):
    """Multilayer perceptron 6-32-32-3."""

    network: Network

    def start(self, period):
        return ()

    def __call__(self, memory, motion):
        return memory, Torque(perceptron(self.network, motion))


class Ring(eqx.Module):
    """Rate damping by the mean of the last eight rates, in a ring buffer."""

    gain: float

    def start(self, period):
        return jnp.zeros((8, 3)), jnp.array(0)

    def __call__(self, memory, motion):
        rates, count = memory
        rates = rates.at[count % 8].set(motion.rate)
        return (rates, count + 1), Torque(-self.gain * jnp.mean(rates, 0))


class Filter(eqx.Module):
    """Kalman filter of angles, rates and external torques, by a Cholesky factorisation."""

    noise: Any

    def start(self, period):
        return jnp.zeros(9), jnp.eye(9)

    def __call__(self, memory, motion):
        state, covariance = memory
        zero, unit = jnp.zeros((3, 3)), jnp.eye(3)
        forward = jnp.block(
            [[unit, PERIOD * unit, zero], [zero, unit, PERIOD * unit], [zero, zero, unit]]
        )
        seen = jnp.eye(6, 9)
        state = forward @ state
        covariance = forward @ covariance @ forward.T + 1e-6 * jnp.eye(9)
        factor = jax.scipy.linalg.cho_factor(seen @ covariance @ seen.T + jnp.diag(self.noise))
        gain = jax.scipy.linalg.cho_solve(factor, seen @ covariance).T
        state = state + gain @ (jnp.concatenate([motion.angle, motion.rate]) - seen @ state)
        covariance = covariance - gain @ seen @ covariance
        return (state, covariance), Torque(-0.01 * state[:3] - 0.1 * state[3:6] - state[6:])


class Predictive(eqx.Module):
    """Model predictive control: 10 samples of 3 torques, 40 projected gradient steps."""

    def start(self, period):
        return jnp.zeros(3 * HORIZON)

    def __call__(self, memory, motion):
        plan, torque = predictive(memory, motion)
        return plan, Torque(torque)


class Calibrating(eqx.Module):
    """Extended Kalman filter of 15 states."""

    def start(self, period):
        zero = jnp.zeros(3)
        attitude = jnp.array([1.0, 0.0, 0.0, 0.0])
        return Estimate(attitude, zero, zero, zero, zero, jnp.diag(jnp.array(START)))

    def __call__(self, memory, sensors):
        memory = filtered(memory, sensors)
        return memory, Torque(-0.1 * memory.bias)


def user(controller, measured):
    """Flight module of a controller of a user."""
    measured = jax.tree.map(lambda leaf: jnp.asarray(leaf[:STEPS]), measured)
    guard = MeasurementGuard.of(jax.tree.map(lambda leaf: leaf[0], measured))
    return targets.flight_loop("law", "Law of a user", controller, PERIOD, guard, measured)


MODULES = {
    **PARTS,
    "compensator_float": PARTS["compensator"],
    "user_ring": lambda: user(Ring(0.1), Motion(*motions())),
    "user_perceptron": lambda: user(Perceptron(network()), Motion(*motions())),
    "user_filter": lambda: user(Filter(np.full(6, 1e-4)), Motion(*motions())),
    "user_predictive": lambda: user(Predictive(), Motion(*motions())),
    "user_calibrating": lambda: user(Calibrating(), Sensors(*sensed())),
    **{
        name: lambda name=name: of_scenario(EXAMPLES / "scenarios" / f"{name}.toml")
        for name in SCENARIOS
    },
    "mission": lambda: of_scenario(EXAMPLES / "missions" / "earth_observation" / "mission.toml"),
}
"""Name -> flight module; in single precision if the name says so."""


def prove(name, limit):
    """Prove a module; whether it is proven."""
    target = MODULES[name]()
    texts = files(target, "float" if name.endswith("_float") else "double", "Made by a benchmark.")
    with tempfile.TemporaryDirectory() as folder:
        write_texts(Path(folder), texts)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        script = Path(folder) / "evidence" / "run.sh"
        subprocess.run(
            ["sh", str(script), "run_time_errors"],
            check=False,
            stdout=subprocess.DEVNULL,
            env={**os.environ, "SECONDS_LIMIT": str(limit)},
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime - before.ru_utime
        results = read_results(Path(folder))
    result = next(each for each in results if each.name == "run_time_errors")
    figures = {figure.name: figure for figure in result.figures}

    def value(figure):
        return figures[figure].value if figure in figures else "-"

    reached = figures.get("statements reached")
    print(
        f"{name:22s} {len(texts[f'{target.name}.c']) / 1000.0:7.0f} {value('alarms'):>6s} "
        f"{value('results proven to be finite'):>7s} "
        f"{value('results not proven to be finite'):>10s} "
        f"{f'{reached.value} {reached.unit}' if reached else '-':>15s} {seconds:8.1f}",
        result.outcome if result.outcome == "passed" else str(result),
        flush=True,
    )
    return result.outcome == "passed"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("names", nargs="*", default=list(MODULES), metavar="NAME")
    parser.add_argument("--limit", type=int, default=3600, help="seconds of an analysis")
    options = parser.parse_args()
    print("module                   C, kB alarms  finite not proven      statements  seconds")
    outcomes = [prove(name, options.limit) for name in options.names]
    return 0 if all(outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
