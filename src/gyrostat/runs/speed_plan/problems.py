"""Plan of wheel speeds as linear inequalities with choices of intervals.

The variables are, for each science window, the change D of the total momentum by unloading until
then (inertial axes) and the null-space momentum z. With the momenta q of the wheels that the run
asks for without unloading, the wheels have in the window

    h(t) = q(t) + A⁺ R(t)' D + d z.

Each wheel must stay in one interval of h in each window, since it cannot pass from one to another
without being between them. Two problems enclose the truth:

- A solution of the sufficient problem can be flown. In the time T before a window, the actuator
  gives the constant inertial torque u = (change of D) / T, within part of its limit L in every
  attitude of that time: |R'u| <= s L for each axis. What is left of L is for deviations from the
  plan. The wheels move to z by part of their torque. On the way there, such as in a slew, they have
  room for the rate of the body, up to which the law limits it.
- If the necessary problem of `necessary.py` has no solution, no control can avoid the crossings
  with these attitudes and external torques.
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
ATTEMPTS = ((0.9, True), (1.0, True), (1.0, False))
"""Shares s of the actuator's torque that a plan may use, and whether the wheels keep room on the
way; the first with a plan is taken."""
LEFT = 0.02
"""Error of the null-space momentum at the start of a window over the clearance."""
TIMES = 24
"""Most times before a window at which the limits of actuator and wheels are rows."""
EXTRA = 3.0
"""Extra clearance that is worth while over the required one."""
WORTH = 10.0
"""Worth of extra clearance of a wheel over that of as much momentum unloaded: deviations from the
plan cross zero first where the clearance is least."""


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
    """

    across: Matrix
    spread: Vector
    low: Vector
    high: Vector


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
            )
        )
    return parts


def _unloading_time(demand: Demand, window: Window) -> float:
    """Time before a window in which the actuator works, s."""
    return float(demand.time[window.begin] - demand.time[window.before])


def _times_before(window: Window) -> np.ndarray:
    """Numbers of some samples of the time before a window, the first and the last among them."""
    count = min(TIMES, window.begin - window.before + 1)
    return np.linspace(window.before, window.begin, count).astype(int)


def _way(
    demand: Demand, limits: Limits, clearance: float, number: int
) -> tuple[Matrix, Vector, Vector]:
    """Momenta of the wheels in the time before a window: rows of D and z, and both bounds.

    The law needs the momentum of the body's rate twice: to take it up, and as room.
    """
    window, wheels = demand.windows[number], limits.axes.shape[1]
    times = _times_before(window)[1:]
    share = (times - window.before) / max(window.begin - window.before, 1)
    across = np.einsum("wi,tji->twj", np.linalg.pinv(limits.axes), demand.rotation[times])
    rows = np.zeros((len(times), wheels, 4 * len(demand.windows)))
    rows[:, :, 4 * number : 4 * number + 3] = share[:, None, None] * across
    rows[:, :, 4 * number + 3] = limits.direction
    if number:
        rows[:, :, 4 * number - 4 : 4 * number - 1] = (1.0 - share)[:, None, None] * across
    turning = demand.turning[times]
    most = (limits.momentum - clearance * limits.inertia - np.abs(turning)).ravel()
    demanded = (demand.wheels[times] + turning).ravel()
    return rows.reshape(len(most), -1), -most - demanded, most - demanded


def _steps(
    demand: Demand, limits: Limits, clearance: float, share: float, keeps_room: bool
) -> tuple[Matrix, Vector]:
    """Rows of the sufficient problem on the changes from window to window, and their bounds."""
    size = 4 * len(demand.windows)
    fastest = ROOM * np.min(limits.torque)
    largest = np.max(np.abs(limits.direction), initial=0.0)
    settles = np.log(np.max(limits.momentum) / (LEFT * clearance * np.min(limits.inertia)))
    matrices, bounds = [], []
    for k, window in enumerate(demand.windows):
        time = _unloading_time(demand, window)
        move = 0.0
        if largest > 0.0:
            move = max(0.0, fastest / largest * (time - settles / limits.crossing_gain))
        unload = np.concatenate(demand.rotation[_times_before(window)].transpose(0, 2, 1))
        count = len(unload)
        change, offset = np.zeros((count + 1, size)), np.zeros(count + 1)
        change[:count, 4 * k : 4 * k + 3] = unload
        change[count, 4 * k + 3] = 1.0
        if k:
            change[:, 4 * k - 4 : 4 * k] = -change[:, 4 * k : 4 * k + 4]
        else:
            offset[count] = demand.level
        bound = np.append(np.full(count, share * limits.external_torque * time), move)
        matrices += [change, -change]
        bounds += [bound + offset, bound - offset]
        if keeps_room:
            rows, low, high = _way(demand, limits, clearance, k)
            matrices += [rows, -rows]
            bounds += [high, -low]
    return np.vstack(matrices), np.concatenate(bounds)


def sufficient(
    demand: Demand, limits: Limits, clearance: float, share: float, keeps_room: bool
) -> Problem:
    """Problem whose solutions can be flown.

    Its variables are D and z of each window, the extra clearance, and the sizes of the changes.

    Args:
        demand: Demanded momenta.
        limits: Wheels and actuator.
        clearance: Distance from zero speed, bands and limits, rad/s.
        share: Share of the actuator's torque that the plan may use.
        keeps_room: Whether the wheels keep room for the rate of the body on the way.
    """
    count, wheels = len(demand.windows), limits.axes.shape[1]
    own = 4 * count
    matrix, bound = _steps(demand, limits, clearance, share, keeps_room)
    total = 2 * own + 1
    # largest change of momentum about any axis of any attitude
    farthest = (
        np.sqrt(3.0)
        * limits.external_torque
        * np.cumsum([_unloading_time(demand, window) for window in demand.windows])
    )
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
                slack = part.spread[wheel] * farthest[k]
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
    limit[:own] = np.tile([*(3 * [farthest[-1]]), 4.0 * most], count)
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

    It is the sum of all changes of momentum and a tenth of the null-space motion, less `WORTH`
    times the momentum of the extra clearance.
    """
    own = 4 * len(demand.windows)
    cost = np.zeros(2 * own + 1)
    cost[own] = -WORTH * float(np.mean(limits.inertia))
    cost[own + 1 :] = np.tile([1.0, 1.0, 1.0, 0.1], len(demand.windows))
    return cost
