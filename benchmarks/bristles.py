"""The bristle wheel of Moreira, Lopes and Kuga in closed loop, 300 s, against scipy; batches.

    python benchmarks/bristles.py [--runs 1000] [--quick]

The peers restart in every control period, as a sampled loop must, and are given the torque that our
run commanded. Error is that of the momentum against Radau at 1e-12. RK45, whose step the bristles
hold at 1e-4 s, is timed over two seconds at the reference and multiplied; `--quick` leaves it out.
Where Numba is installed, LSODA also has a compiled right-hand side. Last, a step of the extended
filter. Times are those of the processor, which other work on a shared machine disturbs least: bind
the process to one core.
"""

import argparse
import importlib
import importlib.util
import time

import equinox as eqx
import numpy as np
from scipy.integrate import odeint, solve_ivp

from gyrostat.control import FrictionTorqueControl
from gyrostat.core.jax64 import jax, jnp
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.papers.moreira_lopes_kuga.setup import (
    BENCH,
    FILTER,
    GAIN,
    INERTIA,
    SENSOR,
    WHEEL,
    to_reference,
)
from gyrostat.simulation import run
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import static_curve

CONTROL = FrictionTorqueControl(FILTER, GAIN, to_reference)
COUNT = 300
BLOCK = 64
"""Runs that `simulate` carries together."""
ESTIMATOR = FrictionScaleFilter(
    Wheel(INERTIA, 1.0, static_curve(WHEEL.friction)), speed_sigma=0.5, scale_drift=8e-4
)


def fly(key):
    """One run without labels."""
    return run(BENCH, CONTROL, SENSOR, BENCH.start(), key, 1.0, count=COUNT)


def best(function, repeats=5):
    """Shortest of some times, after one that compiles, s."""
    jax.block_until_ready(function())
    times = []
    for _ in range(repeats):
        before = time.process_time()
        jax.block_until_ready(function())
        times.append(time.process_time() - before)
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
    before = time.process_time()
    for torque, fading in commands[first:]:
        y = solve_ivp(rate, (0.0, 1.0), y, method, args=(torque, fading), **options).y[:, -1]
        momenta.append(y[0])
    return np.array(momenta), time.process_time() - before


def compiled_peer(commands):
    """LSODA on a right-hand side that Numba compiled, by the shortest way that scipy has.

    Returns:
        A function of rtol: momenta after each second, and the time it took, s.
    """
    numba = importlib.import_module("numba")

    @numba.njit(fastmath=True)
    def compiled(t, y, torque, fading):
        v = 0.006 / INERTIA * y[0]
        level = 2.0 + 0.5 * np.exp(-((v / 0.01) ** 2))
        z_rate = v - 1e5 * abs(v) / level * y[1]
        friction = 0.006 * (1e5 * y[1] + 495.0 * z_rate + 4.6 * v)
        return np.array([torque + fading * np.exp(-GAIN * t) - friction, z_rate])

    pairs = [(float(torque), float(fading)) for torque, fading in commands]
    second = np.array([0.0, 1.0])

    def fly_peer(rtol):
        y, momenta = np.zeros(2), np.empty(len(pairs))
        before = time.process_time()
        for k, pair in enumerate(pairs):
            y = odeint(compiled, y, second, pair, rtol=rtol, atol=1e-4 * rtol, tfirst=True)[1]
            momenta[k] = y[0]
        return momenta, time.process_time() - before

    fly_peer(1e-6)  # compiles
    return fly_peer


def estimate(noise):
    """The extended filter on a wheel that is driven to and fro."""
    torque = 0.03 * (-1.0) ** (jnp.arange(COUNT) // 40)

    def tick(estimate, now):
        drive, draw = now
        estimate = ESTIMATOR.correct(estimate, estimate.speed + draw)
        return ESTIMATOR.predict(estimate, drive, 1.0), estimate.scale

    return jax.lax.scan(tick, ESTIMATOR.start(), (torque, noise))[1]


def batches(key, ours, runs):
    """Print what runs, and steps of the filter, cost side by side."""
    many = eqx.filter_jit(jax.vmap(fly))
    print("\n| runs in a batch | time (s) | over one run |\n|---|---|---|")
    for count in (BLOCK, runs):
        keys = jax.random.split(key, count)
        elapsed = best(lambda: many(keys), 20)  # noqa: B023
        print(f"| {count} | {elapsed:.3g} | {elapsed / ours:.3g} |", flush=True)
    blocks = [keys[k : k + BLOCK] for k in range(0, runs - BLOCK + 1, BLOCK)]
    elapsed = best(lambda: [many(block) for block in blocks], 20) * runs / (BLOCK * len(blocks))
    print(f"| {runs}, {BLOCK} at a time | {elapsed:.3g} | {elapsed / ours:.3g} |", flush=True)
    print("\n| a step of the extended filter | time (µs) |\n|---|---|")
    for count in (1, 256):
        noise = 0.5 * jax.random.normal(key, (count, COUNT))
        steps = jax.jit(jax.vmap(estimate))
        elapsed = best(lambda: steps(noise), 20) / (count * COUNT)  # noqa: B023
        print(f"| in a batch of {count} | {1e6 * elapsed:.3g} |", flush=True)


def main():
    """Print three tables."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--runs", type=int, default=1000)
    arguments.add_argument("--quick", action="store_true")
    asked = arguments.parse_args()
    key = jax.random.key(0)
    single = eqx.filter_jit(fly)
    ours = best(lambda: single(key), 200)
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
    if importlib.util.find_spec("numba") is None:
        print("| LSODA, right-hand side compiled: Numba is not installed | | | |")
    else:
        fly_peer = compiled_peer(commands)
        for rtol in (1e-6, 1e-7, 1e-8):
            tries = [fly_peer(rtol) for _ in range(20)]
            error = np.max(np.abs(tries[0][0] - exact)) / scale
            elapsed = min(each for _, each in tries)
            row(f"`odeint` (LSODA), compiled, rtol {rtol:.0e}", elapsed, f"{error:.1e}")
    if not asked.quick:
        settled = (exact[-3], 2e-5)
        _, elapsed = peer(commands, "RK45", first=COUNT - 2, start=settled)
        row("`solve_ivp` RK45, default tolerances, from 2 s", elapsed * COUNT / 2.0, "")
    batches(key, ours, asked.runs)


if __name__ == "__main__":
    main()
