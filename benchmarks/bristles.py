"""The bristle wheel of Moreira, Lopes and Kuga in closed loop, 300 s, against scipy; batches.

    python benchmarks/bristles.py [--runs 1000]

The peers restart in every control period, as a sampled loop must, and are given the torque that our
run commanded. Error is that of the momentum against Radau at 1e-12. RK45, whose step the bristles
hold at 1e-4 s, is timed over two seconds at the reference and multiplied.
"""

import argparse
import time

import equinox as eqx
import numpy as np
from scipy.integrate import solve_ivp

from gyrostat._jax import jax
from gyrostat.control import FrictionTorqueControl
from gyrostat.papers.moreira_lopes_kuga.printed import (
    BENCH,
    FILTER,
    GAIN,
    INERTIA,
    SENSOR,
    to_reference,
)
from gyrostat.simulate import run

CONTROL = FrictionTorqueControl(FILTER, GAIN, to_reference)
COUNT = 300


def fly(key):
    """One run without labels."""
    return run(BENCH, CONTROL, SENSOR, BENCH.start(), key, 1.0, count=COUNT)


def best(function, repeats=5):
    """Shortest of some times, after one that compiles, s."""
    jax.block_until_ready(function())
    times = []
    for _ in range(repeats):
        before = time.perf_counter()
        jax.block_until_ready(function())
        times.append(time.perf_counter() - before)
    return min(times)


def rate(t, y, torque, fading):
    """h and z of eq. (5), with the sign of its exponent corrected."""
    v = 0.006 / INERTIA * y[0]
    level = 2.0 + 0.5 * np.exp(-((v / 0.01) ** 2))
    z_rate = v - 1e5 * abs(v) / level * y[1]
    friction = 0.006 * (1e5 * y[1] + 495.0 * z_rate + 4.6 * v)
    return [torque + fading * np.exp(-GAIN * t) - friction, z_rate]


def peer(commands, method, first=0, start=(0.0, 0.0), **options):
    """Momenta after each second, and the time it took, s."""
    y, momenta = np.array(start), []
    before = time.perf_counter()
    for torque, fading in commands[first:]:
        y = solve_ivp(rate, (0.0, 1.0), y, method, args=(torque, fading), **options).y[:, -1]
        momenta.append(y[0])
    return np.array(momenta), time.perf_counter() - before


def main():
    """Print two tables."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=1000)
    runs = arguments.parse_args().runs
    key = jax.random.key(0)
    single = eqx.filter_jit(fly)
    ours = best(lambda: single(key))
    found = single(key)
    commands = np.column_stack([found.command.torque, found.command.fading_torque])[:-1]
    momentum = INERTIA * np.asarray(found.state.speed)[1:]
    exact, _ = peer(commands, "Radau", rtol=1e-12, atol=1e-16)
    print("| one run of 300 s | time (s) | over gyrostat | largest error of h (relative) |")
    print("|---|---|---|---|")
    scale = np.max(np.abs(exact))

    def row(name, elapsed, error):
        print(f"| {name} | {elapsed:.4g} | {elapsed / ours:.3g} | {error} |", flush=True)

    row("gyrostat", ours, f"{np.max(np.abs(momentum - exact)) / scale:.1e}")
    for method, options in (
        ("LSODA", {"rtol": 1e-8, "atol": 1e-12}),
        ("Radau", {"rtol": 1e-8, "atol": 1e-12}),
    ):
        momenta, elapsed = peer(commands, method, **options)
        error = np.max(np.abs(momenta - exact)) / scale
        row(f"`solve_ivp` {method}, rtol 1e-8", elapsed, f"{error:.1e}")
    settled = (exact[-3], 2e-5)
    _, elapsed = peer(commands, "RK45", first=COUNT - 2, start=settled)
    row("`solve_ivp` RK45, default tolerances, from 2 s", elapsed * COUNT / 2.0, "")
    print("\n| runs in a batch | time (s) | over one run |\n|---|---|---|")
    for count in (64, runs):
        many = eqx.filter_jit(jax.vmap(fly))
        keys = jax.random.split(key, count)
        elapsed = best(lambda: many(keys), 3)  # noqa: B023
        print(f"| {count} | {elapsed:.3g} | {elapsed / ours:.3g} |", flush=True)


if __name__ == "__main__":
    main()
