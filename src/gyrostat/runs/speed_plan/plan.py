"""Plan of wheel speeds for the science windows of a run, or proof that there is none."""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.speed_plan.choices import Certificate, Problem, infeasible, solve
from gyrostat.runs.speed_plan.demand import Demand, Limits
from gyrostat.runs.speed_plan.necessary import necessary
from gyrostat.runs.speed_plan.problems import ATTEMPTS, cost_of, sufficient

FOLLOWED = 0.05
"""Largest deviation of the wanted momentum from that without unloading, over the clearance: the
actuator spends torque on it."""
SHORTEST = 10
"""Least number of control periods of an entry."""
FOUND, INFEASIBLE, NOT_FOUND = "found", "infeasible", "not found"


class Entry(NamedTuple):
    """Entry of a plan, see `gyrostat.control.MomentumPlan`.

    Attributes:
        time: Start, s.
        unloads: Time from there in which the external actuator works, s.
        momentum: Total momentum after it, inertial axes, (3,), N·m·s.
        null_space: Null-space momentum z, N·m·s.
        momentum_rate: Rate of the wanted total momentum, inertial axes, (3,), N·m.
        torque: Feed-forward torque of the actuator, inertial axes, (3,), N·m.
        window: Time interval of the science window that it serves, s.
    """

    time: float
    unloads: float
    momentum: Vector
    null_space: float
    momentum_rate: Vector
    torque: Vector
    window: tuple[float, float]


class Plan(NamedTuple):
    """Answer of the planner.

    Attributes:
        answer: `FOUND`, `INFEASIBLE` or `NOT_FOUND`.
        entries: Entries of the plan; none without one.
        impulse: Sum of the sizes of the planned changes of momentum about each axis, N·m·s.
        certificate: Proof that there is no plan; None without one.
        problem: Problem without a solution to which it refers.
        windows: Numbers of the science windows to which the proof refers, from 0.
    """

    answer: str
    entries: tuple[Entry, ...] = ()
    impulse: float = 0.0
    certificate: Certificate | None = None
    problem: Problem | None = None
    windows: tuple[int, ...] = ()


def scaled(demand: Demand, limits: Limits) -> tuple[Demand, Limits, float]:
    """Demand and limits with the largest momentum limit of a wheel as the unit of momentum.

    Returns:
        Demand, limits, and the unit, N·m·s.
    """
    unit = float(np.max(limits.momentum))
    return (
        demand._replace(
            total=demand.total / unit,
            wheels=demand.wheels / unit,
            turning=demand.turning / unit,
            level=demand.level / unit,
        ),
        limits._replace(
            inertia=limits.inertia / unit,
            momentum=limits.momentum / unit,
            torque=limits.torque / unit,
            external_torque=limits.external_torque / unit,
        ),
        unit,
    )


def plan_of(demand: Demand, limits: Limits, clearance: float, seconds: float = 20.0) -> Plan:
    """Plan that keeps all wheels from zero speed, bands and limits in all science windows.

    Args:
        demand: Demanded momenta.
        limits: Wheels and actuator.
        clearance: Distance from zero speed, bands and limits, rad/s.
        seconds: Time for each search.
    """
    demand, limits, unit = scaled(demand, limits)
    for share, keeps_room in ATTEMPTS:
        problem = sufficient(demand, limits, clearance, share, keeps_room)
        point, _ = solve(problem, cost_of(demand, limits), seconds)
        if point is not None:
            tolerance = FOLLOWED * clearance * float(np.min(limits.inertia))
            return _found(demand, unit, point, tolerance)
    count = len(demand.windows)
    for only in (*range(count), None) if count > 1 else (None,):
        problem = necessary(demand, limits, clearance, only)
        proof = infeasible(problem, seconds)
        if isinstance(proof, Certificate):
            windows = tuple(range(count)) if only is None else (only,)
            return Plan(INFEASIBLE, certificate=proof, problem=problem, windows=windows)
    return Plan(NOT_FOUND)


def _found(demand: Demand, unit: float, point: Vector, tolerance: float) -> Plan:
    values = point[: 4 * len(demand.windows)].reshape(-1, 4)
    changes = np.diff(values[:, :3], axis=0, prepend=0.0)
    entries = []
    for window, value, change in zip(demand.windows, values, changes, strict=True):
        way = window.begin - window.before
        science = float(demand.time[window.begin]), float(demand.time[window.end - 1])
        knots = _knots(demand.total, window.before, window.begin, tolerance)
        for start, end in pairwise(knots):
            begin, time = float(demand.time[start]), float(demand.time[end] - demand.time[start])
            torque = unit * change / (demand.time[window.begin] - demand.time[window.before])
            left = (window.begin - end) / way
            entries.append(
                Entry(
                    begin,
                    time,
                    unit * (demand.total[end] + value[:3] - left * change),
                    unit * float(value[3]),
                    unit * (demand.total[end] - demand.total[start]) / time + torque,
                    torque,
                    science,
                )
            )
        if way == 0:
            momentum, rest = unit * (demand.total[window.begin] + value[:3]), np.zeros(3)
            level = unit * float(value[3])
            entries.append(Entry(science[0], 0.0, momentum, level, rest, rest, science))
    return Plan(FOUND, tuple(entries), unit * float(np.sum(np.abs(changes))))


def _knots(total: Matrix, start: int, end: int, tolerance: float) -> list[int]:
    """Samples between which the momentum is a straight line, the first and the last among them."""
    share = np.linspace(0.0, 1.0, end - start + 1)[:, None]
    line = (1.0 - share) * total[start] + share * total[end]
    error = np.max(np.abs(total[start : end + 1] - line))
    if end - start < 2 * SHORTEST or error <= tolerance:
        return [start, end] if end > start else [start]
    middle = (start + end) // 2
    first = _knots(total, start, middle, tolerance)
    return first[:-1] + _knots(total, middle, end, tolerance)
