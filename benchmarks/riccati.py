"""State-dependent Riccati control of a cube for 200 s at 100 Hz: gyrostat against scipy; a batch.

    OMP_NUM_THREADS=1 python benchmarks/riccati.py [--runs 256] [--steps 20000] [--stages]

The plant and the weights are those of Carvalho and Fenili, RK4 at 0.01 s. The law is evaluated once
a step and held, or with --stages at each of the four. The peer is the same loop in NumPy with
scipy.linalg.solve_continuous_are and one BLAS thread. Times are processor times, all threads
together: those of a machine that does nothing else.
"""

import argparse
import math
import time

import numpy as np
from scipy.linalg import solve_continuous_are

from gyrostat.control import EulerCube, StateDependentRiccati
from gyrostat.core.jax64 import jax, jnp

INERTIA, STEP = 12.0, 0.01
WEIGHT = np.diag([50.0, 50.0, 10.0, 10.0, 10.0, 10.0])
EFFORT = np.diag([50.0, 100.0, 100.0])
START = np.array([0.8 - np.pi / 2, 0.04, 0.7, 0.04, 0.6, 0.04])


def factorised(x):
    """Eqs. (17), (18), corrected, in plain Python."""
    sine, cosine = math.cos(x[0]), -math.sin(x[0])
    s, c = math.sin(x[4]) / INERTIA, math.cos(x[4]) / INERTIA
    a, b = np.zeros((6, 6)), np.zeros((6, 3))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[1, 3] = -x[5] * sine
    a[3, 3], a[3, 5] = -x[1] * cosine / sine, x[1] / sine
    a[5, 1], a[5, 3] = -x[5] * cosine / sine, x[1] / sine
    b[1] = c, -s, 0.0
    b[3] = s / sine, c / sine, 0.0
    b[5] = -s * cosine / sine, -c * cosine / sine, 1.0 / INERTIA
    return a, b


def peer_torque(x):
    a, b = factorised(x)
    cost = solve_continuous_are(a, b, WEIGHT, EFFORT)
    return -(b.T @ cost @ x) / np.diag(EFFORT)


def rk4(rate, x):
    a = rate(x)
    b = rate(x + 0.5 * STEP * a)
    c = rate(x + 0.5 * STEP * b)
    return x + STEP / 6.0 * (a + 2.0 * b + 2.0 * c + rate(x + STEP * c))


def peer(steps, stages):
    """State after some steps."""
    x = START

    def rate(x, torque=None):
        a, b = factorised(x)
        return a @ x + b @ (peer_torque(x) if torque is None else torque)

    for _ in range(steps):
        torque = None if stages else peer_torque(x)
        x = rk4(lambda y, u=torque: rate(y, u), x)
    return x


def ours(steps, stages, doublings):
    """The same loop; compiled by the caller."""
    plant = EulerCube(INERTIA)
    law = StateDependentRiccati(plant, WEIGHT, EFFORT, doublings=doublings)

    def times(matrix, vector):
        return jnp.sum(matrix * vector, axis=1)

    def step(carry, _):
        x, valid = carry
        command = law.command(x)

        def rate(y):
            a, b = plant(y)
            return times(a, y) + times(b, (law.command(y) if stages else command).torque)

        return (rk4(rate, x), valid & command.valid), None

    return lambda x: jax.lax.scan(step, (x, jnp.array(True)), None, length=steps)[0]


def best(call, repeats):
    shortest = math.inf
    for _ in range(repeats):
        began = time.process_time()
        jax.block_until_ready(call())
        shortest = min(shortest, time.process_time() - began)
    return shortest


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=256)
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--stages", action="store_true")
    options = parser.parse_args()
    steps, stages = options.steps, options.stages

    began = time.process_time()
    expected = peer(steps, stages)
    base = time.process_time() - began
    print("| what | time (s) | compiled in (s) | a run, over scipy | largest state error |")
    print("|---|---|---|---|---|")
    print(f"| scipy | {base:.3g} | | 1 | |", flush=True)
    starts = START * np.random.default_rng(0).uniform(0.8, 1.2, (options.runs, 6))
    starts[0] = START
    for doublings in (14, 8):
        for runs, argument in ((1, START), (options.runs, starts))[: 1 if doublings == 14 else 2]:
            loop = ours(steps, stages, doublings)
            began = time.process_time()
            whole = loop if runs == 1 else lambda x, one=loop: jax.lax.map(one, x, batch_size=64)
            call = jax.jit(whole).lower(argument).compile()
            compiled = time.process_time() - began
            taken = best(lambda: call(argument), options.repeats if runs == 1 else 1)  # noqa: B023
            state, valid = call(argument)
            first = state if runs == 1 else state[0]
            error = np.max(np.abs(np.asarray(first) - expected))
            name = f"{runs} at a time, {doublings} doublings" + (
                "" if np.all(valid) else ", NOT VALID"
            )
            print(
                f"| {name} | {taken:.3g} | {compiled:.1f} | {base * runs / taken:.1f} "
                f"| {error:.1e} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
