"""Plan of wheel speeds for the science windows of a run, or proof that there is none."""

from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.runs.speed_plan.choices import Certificate, Problem, infeasible, solve
from gyrostat.runs.speed_plan.demand import Demand, Limits
from gyrostat.runs.speed_plan.necessary import necessary
from gyrostat.runs.speed_plan.problems import SHARES, cost_of, sufficient

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
    for share in SHARES:
        problem = sufficient(demand, limits, clearance, share)
        point, _ = solve(problem, cost_of(demand, limits), seconds)
        if point is not None:
            return _found(demand, unit, point)
    count = len(demand.windows)
    for only in (*range(count), None) if count > 1 else (None,):
        problem = necessary(demand, limits, clearance, only)
        proof = infeasible(problem, seconds)
        if isinstance(proof, Certificate):
            windows = tuple(range(count)) if only is None else (only,)
            return Plan(INFEASIBLE, certificate=proof, problem=problem, windows=windows)
    return Plan(NOT_FOUND)


def _found(demand: Demand, unit: float, point: Vector) -> Plan:
    values = point[: 4 * len(demand.windows)].reshape(-1, 4)
    changes = np.diff(values[:, :3], axis=0, prepend=0.0)
    entries = []
    for window, value, change in zip(demand.windows, values, changes, strict=True):
        begin, end = (float(demand.time[at]) for at in (window.before, window.begin))
        drift = demand.total[window.begin] - demand.total[window.before]
        over = unit / (end - begin) if end > begin else 0.0
        entries.append(
            Entry(
                begin,
                end - begin,
                unit * (demand.total[window.begin] + value[:3]),
                unit * float(value[3]),
                over * (drift + change),
                over * change,
                (end, float(demand.time[window.end - 1])),
            )
        )
    return Plan(FOUND, tuple(entries), unit * float(np.sum(np.abs(changes))))
