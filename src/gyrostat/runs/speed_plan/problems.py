"""Plan of wheel speeds as linear inequalities with choices of intervals.

The variables are, for each science window, the change D of the total momentum by unloading until
then (inertial axes) and the null-space momentum z. With the momenta q of the wheels that the run
asks for without unloading, the wheels have in the window

    h(t) = q(t) + A⁺ R(t)' D + d z.

Each wheel must stay in one interval of h in each window, since it cannot pass from one to another
without being between them. Two problems enclose the truth:

- A solution of the sufficient problem can be flown. In the time before a window, the actuator
  changes D by the law of `MomentumUnloading`: |e| decreases as if it were the error of one axis, so
  that it is below e_1 after the time T if |e_0| <= (L / k) (1 + k T - ln(L / (k e_1))), with the
  torque L that external torques leave and the gain k. The wheels move to z by part of their torque.
- If the necessary problem has no solution, no control can avoid the crossings with these attitudes
  and external torques. There the actuator changes the momentum n'D by at most the integral of
  L |R'n|_1 for any direction n, and the null-space momentum is free at each time.
"""

from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.speed_plan.choices import Choice, Problem
from gyrostat.runs.speed_plan.demand import Demand, Limits, Window

CHUNKS = 30
"""Parts of a window, each with one attitude and the extreme momenta of its samples."""
ROOM = 0.4
"""Share of the wheels' torque that moves them in the null space."""
LEFT = 0.02
"""Error of a momentum at the start of a window over the clearance."""
EXTRA = 3.0
"""Extra clearance that is worth while over the required one."""
AT_REST = 1e-3
"""Largest component of a rotation matrix's change of an attitude at rest."""


def intervals(limits: Limits, wheel: int, clearance: float) -> Matrix:
    """Intervals of the momentum of a wheel, increasing, (intervals, 2), N·m·s.

    Args:
        limits: Wheels.
        wheel: Number of the wheel.
        clearance: Distance from zero speed, bands and limits, rad/s.
    """
    inertia = limits.inertia[wheel]
    most = limits.momentum[wheel] - clearance * inertia
    blocked = [(0.0, clearance), *((a - clearance, b + clearance) for a, b in limits.bands)]
    free, start = [], 0.0
    for low, high in sorted((max(a, 0.0) * inertia, b * inertia) for a, b in blocked):
        if start < min(low, most):
            free.append((start, min(low, most)))
        start = max(start, high)
    if start < most:
        free.append((start, most))
    both = [(-b, -a) for a, b in reversed(free)] + free
    return np.array(both).reshape(-1, 2)


class _Part(NamedTuple):
    """Part of a window.

    Attributes:
        across: A⁺ R' at its middle, (wheels, 3).
        spread: Largest length of its changes over the part, (wheels,).
        low: Least demanded momentum, (wheels,), N·m·s.
        high: Largest demanded momentum, (wheels,), N·m·s.
        middle: Demanded momentum at its middle, (wheels,), N·m·s.
    """

    across: Matrix
    spread: Vector
    low: Vector
    high: Vector
    middle: Vector


def _parts(demand: Demand, limits: Limits, window: Window) -> list[_Part]:
    inverse = np.linalg.pinv(limits.axes)
    count = min(CHUNKS, window.end - window.begin)
    parts = []
    for rows in np.array_split(np.arange(window.begin, window.end), count):
        across = np.einsum("wi,tji->twj", inverse, demand.rotation[rows])
        middle, values = len(rows) // 2, demand.wheels[rows]
        parts.append(
            _Part(
                across[middle],
                np.max(np.linalg.norm(across - across[middle], axis=2), axis=0),
                np.min(values, axis=0),
                np.max(values, axis=0),
                values[middle],
            )
        )
    return parts


def _drift(demand: Demand, rows: slice) -> float:
    """Largest external torque about an axis, N·m."""
    total = demand.total[rows]
    if len(total) < 2:
        return 0.0
    step = demand.time[1] - demand.time[0]
    return float(np.max(np.abs(np.diff(total, axis=0)))) / step


def reach(demand: Demand, limits: Limits, window: Window, clearance: float) -> float:
    """Change of momentum that the actuator surely brings about before a window, N·m·s."""
    before = slice(window.before, window.begin + 1)
    gain, time = limits.momentum_gain, demand.time[window.begin] - demand.time[window.before]
    torque = limits.external_torque - _drift(demand, before)
    left = LEFT * clearance * np.min(limits.inertia)
    if torque <= 0.0 or left <= 0.0:
        return 0.0
    return max(0.0, torque / gain * (1.0 + gain * time - np.log(max(torque / (gain * left), 1.0))))


def _steps(
    demand: Demand, limits: Limits, clearance: float, reaches: list[float]
) -> tuple[Matrix, Vector]:
    """Rows of the sufficient problem on the changes from window to window, and their bounds."""
    windows, size = demand.windows, 4 * len(demand.windows)
    fastest = ROOM * np.min(limits.torque)
    largest = np.max(np.abs(limits.direction), initial=0.0)
    settles = np.log(np.max(limits.momentum) / (LEFT * clearance * np.min(limits.inertia)))
    matrices, bounds = [], []
    for k, (window, most) in enumerate(zip(windows, reaches, strict=True)):
        rotation = demand.rotation[window.before : window.begin + 1]
        rests = np.max(np.abs(rotation - rotation[0]), initial=0.0) < AT_REST
        time = demand.time[window.begin] - demand.time[window.before]
        move = 0.0
        if largest > 0.0:
            move = max(0.0, fastest / largest * (time - settles / limits.crossing_gain))
        change = np.zeros((4, size))
        change[:, 4 * k : 4 * k + 4] = np.eye(4)
        change[:3, 4 * k : 4 * k + 3] = rotation[0].T
        offset = np.zeros(4)
        if k:
            change[:, 4 * k - 4 : 4 * k] = -change[:, 4 * k : 4 * k + 4]
        else:
            offset[3] = demand.level
        bound = np.append(np.full(3, most / (1.0 if rests else np.sqrt(3.0))), move)
        matrices += [change, -change]
        bounds += [bound + offset, bound - offset]
    return np.vstack(matrices), np.concatenate(bounds)


def sufficient(demand: Demand, limits: Limits, clearance: float) -> Problem:
    """Problem whose solutions can be flown.

    Its variables are D and z of each window, the extra clearance, and the sizes of the changes.
    """
    count, wheels = len(demand.windows), limits.axes.shape[1]
    own = 4 * count
    reaches = [reach(demand, limits, window, clearance) for window in demand.windows]
    matrix, bound = _steps(demand, limits, clearance, reaches)
    total = 2 * own + 1
    farthest = np.cumsum(reaches)
    matrix = np.column_stack([matrix, np.zeros((len(matrix), total - own))])
    sizes = _sizes(own)
    first = np.zeros(own)
    first[3] = demand.level
    rows = [matrix]
    bounds = [bound]
    for sign in (1.0, -1.0):
        block = np.zeros((own, total))
        block[:, :own] = sign * sizes
        block[:, own + 1 :] = -np.eye(own)
        rows.append(block)
        bounds.append(sign * first)
    choices = []
    for k, window in enumerate(demand.windows):
        parts = _parts(demand, limits, window)
        for wheel in range(wheels):
            block = np.zeros((2 * len(parts), total))
            low, high = np.zeros(len(block)), np.zeros(len(block))
            for number, part in enumerate(parts):
                slack = part.spread[wheel] * np.sqrt(3.0) * farthest[k]
                for half, sign in enumerate((1.0, -1.0)):
                    row = 2 * number + half
                    block[row, 4 * k : 4 * k + 3] = part.across[wheel]
                    block[row, 4 * k + 3] = limits.direction[wheel]
                    # extra clearance on both sides
                    block[row, own] = sign * limits.inertia[wheel]
                    low[row], high[row] = part.low[wheel] - slack, part.high[wheel] + slack
            choices.append(Choice(block, low, high, intervals(limits, wheel, clearance)))
    most = np.max(limits.momentum)
    limit = np.full(total, 8.0 * most)
    limit[:own] = np.tile([*(3 * [2.0 * farthest[-1]]), 4.0 * most], count)
    limit[own] = EXTRA * clearance
    nonnegative = np.zeros((1, total))
    nonnegative[0, own] = -1.0
    matrix = np.vstack([*rows, nonnegative])
    return Problem(matrix, np.append(np.concatenate(bounds), 0.0), limit, tuple(choices))


def _sizes(own: int) -> Matrix:
    """Matrix of the changes from window to window, (4 windows, 4 windows)."""
    matrix = np.eye(own)
    matrix[4:, :-4] -= np.eye(own - 4)
    return matrix


def cost_of(demand: Demand, limits: Limits) -> Vector:
    """Cost of the variables of `sufficient`.

    It is the sum of all changes of momentum and a tenth of the null-space motion, less the momentum
    of the extra clearance.
    """
    own = 4 * len(demand.windows)
    cost = np.zeros(2 * own + 1)
    cost[own] = -float(np.mean(limits.inertia))
    cost[own + 1 :] = np.tile([1.0, 1.0, 1.0, 0.1], len(demand.windows))
    return cost


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
    null = np.linalg.svd(limits.axes)[2][np.linalg.matrix_rank(limits.axes) :].T
    free, chosen = null.shape[1], range(count) if only is None else [only]
    parts = {k: _parts(demand, limits, demand.windows[k]) for k in chosen}
    starts = np.cumsum([3 * count, *(free * len(parts[k]) for k in chosen)])
    total = int(starts[-1])
    matrices, bounds = [], []
    largest = np.zeros(3)
    for k, window in enumerate(demand.windows):
        rotation = demand.rotation[window.before : window.begin + 1]
        directions = np.vstack([np.eye(3), rotation[0].T, rotation[-1].T])
        period = demand.time[1] - demand.time[0]
        within = np.sum(np.abs(np.einsum("tji,nj->tni", rotation[:-1], directions)), axis=2)
        most = limits.external_torque * period * np.sum(within, axis=0)
        block = np.zeros((len(directions), total))
        block[:, 3 * k : 3 * k + 3] = directions
        if k:
            block[:, 3 * k - 3 : 3 * k] = -directions
        matrices += [block, -block]
        bounds += [most, most]
        largest = largest + most[:3]
    choices = []
    for k, start in zip(chosen, starts[:-1], strict=True):
        for wheel in range(wheels):
            block = np.zeros((len(parts[k]), total))
            value = np.array([part.middle[wheel] for part in parts[k]])
            for number, part in enumerate(parts[k]):
                block[number, 3 * k : 3 * k + 3] = part.across[wheel]
                at = start + free * number
                block[number, at : at + free] = null[wheel]
            choices.append(Choice(block, value, value, intervals(limits, wheel, clearance)))
    size = np.append(
        np.tile(largest, count), np.full(total - 3 * count, 4.0 * np.sum(limits.momentum))
    )
    return Problem(np.vstack(matrices), np.concatenate(bounds), size, tuple(choices))
