"""Pointing with two wheels: the paper's loop against scipy's, and dispersed runs in a batch.

OMP_NUM_THREADS=1 python benchmarks/output_zeroing.py [--peer-periods 2000]
"""

import argparse
import dataclasses
import time

import numpy as np
from scipy.integrate import solve_ivp

from gyrostat.papers.endo_sekiguchi_nonaka.controllers import OURS, evaluate
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import draw
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Case, Ideal
from gyrostat.papers.endo_sekiguchi_nonaka.setup import (
    ACTUAL,
    DURATION,
    FEEDBACK,
    MOMENTUM,
    NOMINAL,
    PERIOD,
    ROTOR,
    attitude,
    fixed,
    tuned,
)
from gyrostat.simulation import simulate

RUNS = {"ideal": (Case(total=NOMINAL, momentum=0.0), fixed(0.0))}
RUNS |= {"without MEC": (Case(), fixed(0.0)), "MEC with FRIT": (Case(), tuned())}


def ours(case, controller, engine, duration=DURATION):
    """Processor time of one run after another of the same kind, s; attitudes."""
    plant = case.plant()
    for _ in range(2):
        before = time.process_time()
        run = simulate(
            plant,
            controller,
            Ideal(plant),
            start=plant.start(attitude=attitude()),
            duration=duration,
            control_period=PERIOD,
            engine=engine,
        )
        spent = time.process_time() - before
    return spent, run.attitude.values


def slope(time, q, wheels):
    """(2) and (4)."""
    turn = 2e-4 * np.pi * time
    momentum = MOMENTUM * np.array([np.sin(turn), np.cos(turn), np.sin(turn)])
    v = np.array([[0.0, -q[3], q[2]], [q[3], 0.0, -q[1]], [-q[2], q[1], 0.0]])
    body = (np.eye(3) + 2.0 * q[0] * v + 2.0 * v @ v).T @ momentum
    w = np.linalg.solve(ACTUAL, body - wheels)
    matrix = np.array(
        [[-q[1], -q[2], -q[3]], [q[0], -q[3], q[2]], [q[3], q[0], -q[1]], [-q[2], q[1], q[0]]]
    )
    return 0.5 * matrix @ w


def peer(periods):
    """Processor time of the loop without MEC with solve_ivp in each period, s; attitudes."""
    q, rows = attitude(), []
    before = time.process_time()
    for k in range(periods):
        rows.append(q)
        drive = -0.5 * ROTOR * np.array([[q[0], -q[3]], [q[3], q[0]]]) / np.diag(NOMINAL)[:2]
        wheels = np.append(ROTOR * np.linalg.solve(drive, -FEEDBACK * q[1:3]), 0.0)
        span = (PERIOD * k, PERIOD * (k + 1))
        q = solve_ivp(slope, span, q, args=(wheels,), rtol=1e-9, atol=1e-12).y[:, -1]
        q = q / np.linalg.norm(q)
    return time.process_time() - before, np.array(rows)


def main():
    """Print the table."""
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("--peer-periods", type=int, default=2000)
    periods = arguments.parse_args().peer_periods
    spent, rows = peer(periods)
    whole = spent * DURATION / PERIOD / periods
    print("| what | processor time (s) | over |")
    print("|---|---|---|")
    print(f"| scipy, without MEC, from {periods} periods | {whole:.0f} | 1 |")
    gaps = []
    for name, (case, controller) in RUNS.items():
        for engine in ("jax", "native"):
            taken, found = ours(case, controller, engine)
            print(f"| {name}, 10 000 s, {engine} | {taken:.2f} | {whole / taken:.0f} |")
            if name == "without MEC":
                gaps.append(f"{engine} {np.max(np.abs(found[:periods] - rows)):.1e}")
    cases = draw(256, 1)
    evaluate(dataclasses.replace(OURS, duration=10.0, judged=5.0), cases[:64])
    before, wall = time.process_time(), time.perf_counter()
    evaluate(OURS, cases)
    wall, spent = time.perf_counter() - wall, time.process_time() - before
    print(f"| 256 dispersed runs of 6000 s, compilation included | {spent:.0f} | wall {wall:.0f} |")
    print(f"largest difference to scipy: {', '.join(gaps)}")


if __name__ == "__main__":
    main()
