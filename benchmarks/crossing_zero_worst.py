"""Worst case of the estimating compensator at one crossing of the one-axis table.

    python benchmarks/crossing_zero_worst.py [--runs 64] [--generations 8] [--seed 2]

Differential evolution with a batch as generation looks for the largest attitude error over `BOX`:
errors of the model (set A), external torque and its swing, tachometer noise true and told, friction
after the crossing and time of the crossing, for one and two periods of delay. The noise of a run
belongs to its place in the batch.
"""

import argparse

import equinox as eqx
import numpy as np
from crossing_zero_table import (
    DURATION,
    SET_A,
    Row,
    SwingingTable,
    controllers,
    each,
    errors,
    plants,
)

from gyrostat.papers.carrara_kuga import setup
from gyrostat.simulation import simulate
from gyrostat.spacecraft import Gyro, TableSensors
from gyrostat.wheel import WheelTachometer

BOX = {
    **{name: (1.0 - x, 1.0 + x) for name, x in SET_A.items()},
    "torque": (0.03e-3, 0.46e-3),
    "swing": (0.0, 0.2),
    "swing_period": (60.0, 300.0),
    "phase": (0.0, 2.0 * np.pi),
    "sigma": (0.1 * setup.SPEED_SIGMA, setup.SPEED_SIGMA),
    "told": (0.5 * setup.SPEED_SIGMA, 2.0 * setup.SPEED_SIGMA),
    "after": (0.7, 1.3),
    "crossing": (130.0, 170.0),
}
"""Search space: factors of the model, external torque, N·m, its relative swing, swing period, s,
and phase, noise, rad/s, factor of the friction after the crossing, and its time, s."""


def fly_points(points: np.ndarray, delay: int, seed: int) -> np.ndarray:
    """Largest attitude errors, deg, at points of the box, (runs, names)."""
    own, runs = dict(zip(BOX, points.T, strict=True)), len(points)
    row = Row("", told=own["told"], delay=delay, believed=delay, after=tuple(own["after"]))
    controller = controllers(own, row)
    plant, _ = plants(row, np.random.default_rng(0), runs)
    table = eqx.tree_at(lambda table: table.external_torque, plant.table, own["torque"])
    frequency = 2.0 * np.pi / own["swing_period"]
    plant = SwingingTable(table, own["swing"] * own["torque"], frequency, own["phase"])
    speed = -own["torque"] / setup.INERTIA * own["crossing"]
    sensors = TableSensors(Gyro(sigma=np.radians(0.002)), WheelTachometer(sigma=own["sigma"]))
    flown = simulate(
        each(plant, runs),
        each(controller, runs),
        each(sensors, runs),
        start=each(table.start(speed=speed), runs),
        duration=DURATION,
        control_period=setup.PERIOD,
        command_delay=delay,
        seed=seed,
        runs=runs,
        engine="native",
    )
    return np.where(flown.status.values != 0, np.inf, errors(row, flown))


def worst(delay: int, runs: int, generations: int, seed: int) -> tuple[float, dict[str, float]]:
    """Largest error found, deg, and the point of the box (current-to-best/1/bin).

    Args:
        delay: Delay of the command, periods, known to the controller.
        runs: Size of a generation.
        generations: Number of generations after the first, which is uniform.
        seed: Seed of search and noise.
    """
    random = np.random.default_rng(seed)
    low, high = np.array(list(BOX.values())).T
    points = random.uniform(low, high, (runs, len(BOX)))
    found = fly_points(points, delay, seed)
    for _ in range(generations):
        first, second = (points[random.permutation(runs)] for _ in range(2))
        towards = points[np.argmax(found)] - points
        mutant = points + 0.5 * towards + 0.6 * (first - second)
        taken = random.uniform(size=points.shape) < 0.8
        trial = np.clip(np.where(taken, mutant, points), low, high)
        tried = fly_points(trial, delay, seed)
        better = tried > found
        points, found = np.where(better[:, None], trial, points), np.maximum(found, tried)
    k = int(np.argmax(found))
    return float(found[k]), dict(zip(BOX, points[k], strict=True))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=64)
    parser.add_argument("--generations", type=int, default=8)
    parser.add_argument("--seed", type=int, default=2)
    arguments = parser.parse_args()
    for delay in (1, 2):
        found, point = worst(delay, arguments.runs, arguments.generations, arguments.seed)
        shown = ", ".join(f"{name} {value:.4g}" for name, value in point.items())
        print(f"{delay} periods of delay: {found:.4f} deg at {shown}", flush=True)


if __name__ == "__main__":
    main()
