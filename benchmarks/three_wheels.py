"""Three wheels with dry friction that point a body for 600 s: JAX, lanes, Basilisk, C by hand.

    python benchmarks/three_wheels.py --basilisk PYTHON [--repeats 5] [--duration 600]

PYTHON is an interpreter that has Basilisk (package bsk); it need not have gyrostat. Every run has
its own attitude, rate, wheel speeds and friction; a disturbance torque loads the wheels, so that
some of them go through zero. gyrostat and C take control periods of 0.01 s, Basilisk of 0.1 s, each
with one Runge-Kutta step in it: steps are counted, not seconds of flight. Each has two processes or
threads, which have been started and have loaded and compiled what they need beforehand. They take
turns, and the best of the repeats counts; ratios are of the processor's time, since the machine may
be shared. The case is that of pointing_case.py; three_wheels.c, the same by hand, is compiled here,
where there is a compiler.
"""

import argparse
import ctypes
import multiprocessing
import os
import subprocess
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
from ask_basilisk import Basilisk
from pointing_case import CRAFT, LOCKED, PERIOD, SETTLED, Drawn, Flown, draw, fly, parts

from gyrostat.codegen.simd import compiler
from gyrostat.codegen.simd.batch import lanes
from gyrostat.codegen.simd.compiler import FAST
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax
from gyrostat.runs.fingerprint import FLAGS
from gyrostat.simulation import run
from gyrostat.spacecraft.gyrostat_state import GyrostatState

SOURCE = Path(__file__).with_suffix(".c")
WORKERS, RUNS = 2, {"JAX": 512, "lanes": 256, "C": 1024, "Basilisk": 16}
BATCHES = (64, 128, 256)
"""Runs that JAX takes side by side."""
BASILISK_PERIOD = 0.1


@partial(jax.jit, static_argnums=1)
def fly_block(drawn, count):
    """Runs side by side."""
    return jax.vmap(lambda one: fly(one, jax.random.key(0), count))(drawn)


def one_core():
    """Keep a worker of JAX to one core, each its own, before JAX starts."""
    (number,) = multiprocessing.current_process()._identity
    cores = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {cores[(number - 1) % len(cores)]})


def carry_block(drawn, count):
    """Processor's seconds, and `Flown`."""
    begun = time.process_time()
    flown = jax.tree.map(np.asarray, fly_block(drawn, count))
    return time.process_time() - begun, flown


def by_jax(pool, drawn, count, batch):
    """Batches of runs in worker processes: seconds and processor's seconds, and `Flown`."""
    runs = len(drawn.rate)
    blocks = [(Drawn(*(x[k : k + batch] for x in drawn)), count) for k in range(0, runs, batch)]
    begun = time.perf_counter()
    each = pool.starmap(carry_block, blocks, chunksize=1)
    seconds = time.perf_counter() - begun
    processor, found = zip(*each, strict=True)
    return (seconds, sum(processor)), jax.tree.map(lambda *x: np.concatenate(x), *found)


class InLanes:
    """One run, compiled for lanes."""

    def __init__(self, drawn, count, *flags):
        self.given = drawn, jax.random.key(0)
        function = partial(fly, count=count)
        self.fly = lanes(function, (True, False), self.given, more_flags=flags)

    def __call__(self):
        """Seconds and processor's seconds, and `Flown`."""
        begun = time.perf_counter(), time.process_time()
        flown = self.fly(*self.given, threads=WORKERS)
        return (time.perf_counter() - begun[0], time.process_time() - begun[1]), flown


class InC:
    """The loop by hand, compiled here."""

    def __init__(self, program, folder, *flags):
        library = Path(folder) / f"three_wheels{''.join(flags)}.so"
        command = [*program, "-std=gnu11", "-O3", "-march=native", "-fopenmp", *flags]
        command += ["-shared", "-fPIC", str(SOURCE), "-o", str(library), "-lm"]
        subprocess.run(command, check=True)
        self.fly = ctypes.CDLL(str(library)).fly
        free = LOCKED - CRAFT["rotor"] * np.eye(3)
        stribeck = CRAFT["stribeck_speed"]
        numbers = [
            *(matrix.ravel() for matrix in (LOCKED, np.linalg.inv(LOCKED), np.linalg.inv(free))),
            [CRAFT["rotor"], 1.0 / CRAFT["rotor"], CRAFT["viscous"], CRAFT["coulomb"]],
            [CRAFT["static"], stribeck, 1.0 / stribeck, *CRAFT["torque"]],
            [CRAFT["proportional"], CRAFT["derivative"], PERIOD, SETTLED],
        ]
        self.case = np.concatenate(numbers)

    def __call__(self, drawn, count):
        """Seconds and processor's seconds, and `Flown`."""
        given = np.ascontiguousarray(np.concatenate(drawn, axis=1))
        flown = np.zeros((len(given), 12))
        case, given_at, flown_at = (
            x.ctypes.data_as(ctypes.c_void_p) for x in (self.case, given, flown)
        )
        begun = time.perf_counter(), time.process_time()
        self.fly(case, ctypes.c_long(len(given)), ctypes.c_long(count), given_at, flown_at)
        seconds = time.perf_counter() - begun[0], time.process_time() - begun[1]
        state = GyrostatState(flown[:, 2:6], flown[:, 6:9], flown[:, 9:])
        return seconds, Flown(flown[:, 0] / (count + 1), flown[:, 1], state)


def by_basilisk(basilisk, drawn, step, duration, every=0.0):
    """Seconds and processor's seconds, and the samples of each run."""
    runs = [
        {name: x.tolist() for name, x in zip(Drawn._fields, row, strict=True)}
        for row in zip(*drawn, strict=True)
    ]
    given = {"craft": CRAFT, "step": step, "duration": duration, "every": every}
    return basilisk.ask("three_wheels", runs, **given)


def largest(a, b):
    """Largest difference of two engines' results; of wheel speeds, over the largest of them.

    The runs that both have are compared.
    """
    runs = min(len(a.mean_square), len(b.mean_square))
    a, b = (jax.tree.map(lambda x: x[:runs], each) for each in (a, b))
    scale = jax.tree.map(lambda x: 1.0, a)
    scale = scale._replace(state=scale.state._replace(wheel_speed=np.max(a.state.wheel_speed)))
    gaps = jax.tree.map(lambda x, y, size: np.max(np.abs(x - y)) / size, a, b, scale)
    return max(jax.tree.leaves(gaps))


def agreement(basilisk, duration, factor, every=10.0):
    """Largest differences of gyrostat's and Basilisk's trajectories at equal steps of 0.01 s.

    Of MRP, of rates, rad/s, and of wheel speeds over the largest wheel speed.
    """
    drawn = draw(2, seed=1)
    drawn = drawn._replace(friction=np.full_like(drawn.friction, factor))
    _, theirs = by_basilisk(basilisk, drawn, PERIOD, duration, every)
    count, rows = round(duration / PERIOD), round(every / PERIOD)

    @jax.jit
    def whole(drawn):
        histories = run(*parts(drawn), jax.random.key(0), PERIOD, count=count)
        state = histories.state
        return jax.vmap(rotations.to_mrp)(state.attitude), histories.record.rate, state.wheel_speed

    ours = [[np.asarray(x)[::rows] for x in whole(Drawn(*row))] for row in zip(*drawn, strict=True)]
    gaps = {}
    for place, name in enumerate(("mrp", "rate", "wheel_speed")):
        pairs = zip(ours, theirs, strict=True)
        gaps[name] = max(np.max(np.abs(o[place] - t[name])) for o, t in pairs)
    gaps["wheel_speed"] /= max(np.max(np.abs(o[2])) for o in ours)
    return gaps


def engines_of(folder, pool, basilisk, duration):
    """Name -> (call that gives seconds and results, steps that it takes)."""
    count = round(duration / PERIOD)
    drawn = draw(max(RUNS.values()))
    some = {name: Drawn(*(x[:runs] for x in drawn)) for name, runs in RUNS.items()}
    engines = {}
    for batch in BATCHES:
        flight = partial(by_jax, pool, some["JAX"], count, batch)
        engines[f"JAX, {batch} runs"] = flight, RUNS["JAX"] * count
    program = compiler()
    if program is None:
        print("found no C compiler: lanes and the loop by hand are left out")
    else:
        for words, flags in (("", ()), (", -ffast-math", FAST)):
            by_hand = InC(program, folder, *flags)
            engines["C by hand" + words] = partial(by_hand, some["C"], count), RUNS["C"] * count
            whole = InC(program, folder, "-DEVERYTHING=1", *flags)
            flight = partial(whole, some["C"], count)
            engines["C by hand, everything" + words] = flight, RUNS["C"] * count
            in_lanes = InLanes(some["lanes"], count, *flags)
            engines["lanes" + words] = in_lanes, RUNS["lanes"] * count
    if basilisk is None:
        print("found no --basilisk: it is left out")
    else:
        flight = partial(by_basilisk, basilisk, some["Basilisk"], BASILISK_PERIOD, duration)
        steps = RUNS["Basilisk"] * round(duration / BASILISK_PERIOD)
        engines[f"Basilisk {basilisk.version}"] = (flight, steps)
    return engines


def report(rates, flown):
    """Print the table, and how far C and JAX are from each other."""
    theirs = next((rate for name, (_, rate) in rates.items() if "Basilisk" in name), np.nan)
    by_hand = rates.get("C by hand", (np.nan, np.nan))[1]
    print("| engine | steps/s | steps in a processor's second | over Basilisk | over C by hand |")
    print("|---|---|---|---|---|")
    for name, (all_rate, rate) in rates.items():
        ratios = f"{rate / theirs:.3g} | {rate / by_hand:.2g}"
        print(f"| {name} | {all_rate:.3g} | {rate:.3g} | {ratios} |")
    jaxs = flown[f"JAX, {BATCHES[0]} runs"]
    for name, found in flown.items():
        if name.startswith(("C", "lanes")):
            print(f"{name} less JAX: at most {largest(jaxs, found):.1e}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--basilisk", metavar="PYTHON", help="an interpreter that has it")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--duration", type=float, default=600.0, help="s")
    options = parser.parse_args()
    os.environ.setdefault("OMP_NUM_THREADS", str(WORKERS))
    os.environ.setdefault("XLA_FLAGS", FLAGS["cpu"])  # as campaigns do
    basilisk = None if options.basilisk is None else Basilisk(options.basilisk)
    with (
        tempfile.TemporaryDirectory() as folder,
        multiprocessing.get_context("spawn").Pool(WORKERS, one_core) as pool,
    ):
        engines = engines_of(folder, pool, basilisk, options.duration)
        rates, flown = {name: np.zeros(2) for name in engines}, {}
        for name, (call, _) in engines.items():  # compiles, and loads what is to be loaded
            flown[name] = call()[1]
        for _ in range(options.repeats):
            for name, (call, steps) in engines.items():
                rates[name] = np.maximum(rates[name], steps / np.array(call()[0]))
    report(rates, flown)
    if basilisk is not None:
        for factor, words in ((0.0, "no friction"), (1.0, "friction")):
            gaps = agreement(basilisk, options.duration, factor)
            told = ", ".join(f"{name} {gap:.1e}" for name, gap in gaps.items())
            print(f"gyrostat less Basilisk at {PERIOD} s, {words}: {told}")


if __name__ == "__main__":
    main()
