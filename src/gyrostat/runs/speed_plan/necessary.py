"""Problem without a solution if no control can keep the clearance.

It belongs to the attitudes and external torques of a run, and to windows without unloading. The
actuator changes the momentum n'D by at most the integral of L |R'n|_1 for any direction n, and the
null-space momentum is free at each time.
"""

from itertools import product

import numpy as np

from gyrostat.core.types import Matrix
from gyrostat.runs.speed_plan.choices import Choice, Problem
from gyrostat.runs.speed_plan.demand import Demand, Limits, Window
from gyrostat.runs.speed_plan.problems import intervals

TIMES = 30
"""Most times of a window that count, its ends among them."""


def _directions() -> Matrix:
    """Axes, face diagonals and space diagonals of a cube, one of each pair, (13, 3)."""
    every = np.array([d for d in product((1.0, 0.0, -1.0), repeat=3) if d > (0.0, 0.0, 0.0)])
    return every / np.linalg.norm(every, axis=1)[:, None]


def _reach(demand: Demand, limits: Limits, window: Window) -> tuple[Matrix, np.ndarray]:
    """Directions, (N, 3), and the most that the actuator changes the momentum along each, (N,)."""
    rotation = demand.rotation[window.before : window.begin + 1]
    frames = rotation[[0, len(rotation) // 2, -1]]
    cube = _directions()
    directions = np.vstack([cube, *(cube @ frame.T for frame in frames)])
    period = demand.time[1] - demand.time[0]
    within = np.sum(np.abs(np.einsum("tji,nj->tni", rotation[:-1], directions)), axis=2)
    return directions, limits.external_torque * period * np.sum(within, axis=0)


def necessary(demand: Demand, limits: Limits, clearance: float, only: int | None = None) -> Problem:
    """Problem that has a solution if any control avoids the crossings.

    Its variables are D of each window and the null-space momenta of each of its times.

    Args:
        demand: Demanded momenta.
        limits: Wheels and actuator.
        clearance: Distance from zero speed, bands and limits, rad/s.
        only: Number of the only window that counts; None: all.
    """
    count, wheels = len(demand.windows), limits.axes.shape[1]
    inverse = np.linalg.pinv(limits.axes)
    null = np.linalg.svd(limits.axes)[2][np.linalg.matrix_rank(limits.axes) :].T
    free, chosen = null.shape[1], range(count) if only is None else [only]
    times = {}
    for k in chosen:
        window = demand.windows[k]
        ends = np.linspace(window.begin, window.end - 1, min(TIMES, window.end - window.begin))
        times[k] = ends.astype(int)
    starts = np.cumsum([3 * count, *(free * len(times[k]) for k in chosen)])
    total = int(starts[-1])
    matrices, bounds = [], []
    largest = np.zeros(3)
    for k, window in enumerate(demand.windows):
        directions, most = _reach(demand, limits, window)
        block = np.zeros((len(directions), total))
        block[:, 3 * k : 3 * k + 3] = directions
        if k:
            block[:, 3 * k - 3 : 3 * k] = -directions
        matrices += [block, -block]
        bounds += [most, most]
        # no axis changes by more than the length of the largest change
        largest = largest + np.sqrt(3.0) * np.max(most)
    choices = []
    for k, start in zip(chosen, starts[:-1], strict=True):
        across = np.einsum("wi,tji->twj", inverse, demand.rotation[times[k]])
        for wheel in range(wheels):
            block = np.zeros((len(times[k]), total))
            block[:, 3 * k : 3 * k + 3] = across[:, wheel]
            for number in range(len(block)):
                at = start + free * number
                block[number, at : at + free] = null[wheel]
            value = demand.wheels[times[k], wheel]
            choices.append(Choice(block, value, value, intervals(limits, wheel, clearance)))
    size = np.append(
        np.tile(largest, count), np.full(total - 3 * count, 4.0 * np.sum(limits.momentum))
    )
    return Problem(np.vstack(matrices), np.concatenate(bounds), size, tuple(choices))
