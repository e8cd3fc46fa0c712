"""The closed loop of Carrara and Kuga, 600 s at 10 Hz: gyrostat against scipy, and batches.

    python benchmarks/closed_loop.py [--runs 1000] [--repeats 20]

The peer does what an engineer would write: the dynamic model compensator in plain Python, and one
solve_ivp call for each control period of held current, with its default tolerances and sgn in the
right-hand side. Both commands and states are those of one table with one wheel. What is compiled is
timed apart, as the first call less a later one.
"""

import argparse
import resource
import time

import numpy as np
from scipy.integrate import solve_ivp

from gyrostat.control import AttitudePID, DynamicModelCompensator
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.simulation import run, simulate, stack
from gyrostat.spacecraft import AirBearingTable, TableSensors
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

INERTIA, WHEEL_INERTIA, MOTOR, FAN = 0.495, 1.5e-3, 0.0228, 0.46e-3
VISCOUS, COULOMB, STATIC, STRIBECK_SPEED = FRICTION = (4.83e-6, 0.8795e-3, 0.9055e-3, 0.418879)
GAINS = (0.0571, 0.00234, 0.3126)
SPEED = -673.5 * RPM
PERIOD, DURATION = 0.1, 600.0
COUNT = round(DURATION / PERIOD)


def friction(speed):
    excess = (STATIC - COULOMB) * np.exp(-((speed / STRIBECK_SPEED) ** 2))
    return VISCOUS * speed + np.sign(speed) * (COULOMB + excess)


def peer(method):
    """Attitudes of the loop with one solve_ivp call for each control period."""

    def rates(_, y, torque):
        net = torque - friction(y[2])
        table = (FAN - net) / INERTIA
        return [y[1], table, net / WHEEL_INERTIA - table]

    state, summed, attitudes = np.array([0.0, 0.0, SPEED]), 0.0, [0.0]
    for _ in range(COUNT):
        summed += PERIOD * state[0]
        torque = GAINS[0] * state[0] + GAINS[1] * summed + GAINS[2] * state[1]
        speed = state[2]
        torque += friction(speed) if speed != 0.0 else np.sign(torque) * STATIC
        state = solve_ivp(rates, (0.0, PERIOD), state, method=method, args=(torque,)).y[:, -1]
        attitudes.append(state[0])
    return np.array(attitudes)


def seconds(call, repeats=1):
    """Best time of a call, and what it returned."""
    best = np.inf
    for _ in range(repeats):
        began = time.perf_counter()
        found = call()
        best = min(best, time.perf_counter() - began)
    return best, found


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=20)
    options = parser.parse_args()

    wheel = Wheel(WHEEL_INERTIA, MOTOR, Stribeck(*FRICTION))
    table = AirBearingTable(INERTIA, wheel, external_torque=FAN)
    control = DynamicModelCompensator(AttitudePID(*GAINS), wheel.friction, MOTOR)
    start = table.start(speed=SPEED)
    times = {"duration": DURATION, "control_period": PERIOD}

    def single():
        return simulate(table, control, TableSensors(), start=start, **times)

    first, _ = seconds(single)
    once, data = seconds(single, options.repeats)

    # the loop alone, for where the labels are not wanted
    items = jax.tree.map(lambda x: jnp.asarray(x, float), (table, control, start))

    @jax.jit
    def bare(items):
        plant, controller, state = items
        key = jax.random.key(0)
        return run(plant, controller, TableSensors(), state, key, PERIOD, count=COUNT)

    bare(items)
    loop, _ = seconds(lambda: jax.block_until_ready(bare(items)), options.repeats)

    print("| one run of 600 s | time, s | over gyrostat | largest attitude difference, deg |")
    print("|---|---|---|---|")
    print(f"| gyrostat `simulate` | {once:.4f} | 1 | |")
    print(f"| gyrostat `run`, no labels | {loop:.4f} | {loop / once:.2f} | |")
    for method in ("RK45", "LSODA"):
        took, attitudes = seconds(lambda m=method: peer(m))
        gap = np.rad2deg(np.max(np.abs(attitudes - data.attitude.values)))
        print(f"| solve_ivp {method} | {took:.2f} | {took / once:.0f} | {gap:.1e} |")

    # every run its own wheel and its own start: crossings at other times
    random = np.random.default_rng(0)
    factors = random.uniform(0.9, 1.1, options.runs)
    tables = stack(
        [
            AirBearingTable(
                INERTIA,
                Wheel(WHEEL_INERTIA, MOTOR, Stribeck(VISCOUS, f * COULOMB, f * STATIC, 0.418879)),
                external_torque=FAN,
            )
            for f in factors
        ]
    )
    speeds = SPEED + random.uniform(-40.0, 40.0, options.runs) * RPM
    starts = stack([table.start(speed=speed) for speed in speeds])

    def batch(runs):
        own = jax.tree.map(lambda x: x[:runs], (tables, starts))
        return simulate(own[0], control, TableSensors(), start=own[1], runs=runs, **times)

    lanes = min(64, options.runs)
    first_batch, _ = seconds(lambda: batch(lanes))
    block, _ = seconds(lambda: batch(lanes), 2)
    whole, _ = seconds(lambda: batch(options.runs))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print()
    print("| dispersed runs | time, s | runs per second | over one run at a time |")
    print("|---|---|---|---|")
    print(f"| one at a time | {once:.4f} | {1.0 / once:.1f} | 1 |")
    for runs, took in ((lanes, block), (options.runs, whole)):
        print(f"| {runs} | {took:.2f} | {runs / took:.1f} | {runs / took * once:.2f} |")
    print()
    print(
        f"Compiled in {first - once:.1f} s (one run) and {first_batch - block:.1f} s (batch); "
        f"largest memory {memory:.1f} GiB."
    )


if __name__ == "__main__":
    main()
