"""Plan of wheel speeds for the science windows of a run, or proof that there is none."""

from typing import Any, NamedTuple

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.runs.speed_plan.choices import Certificate, Problem, infeasible, solve
from gyrostat.runs.speed_plan.demand import Demand, Limits
from gyrostat.runs.speed_plan.problems import cost_of, necessary, sufficient

FOUND, INFEASIBLE, NOT_FOUND = "found", "infeasible", "not found"


class Entry(NamedTuple):
    """Entry of a plan, see `gyrostat.control.MomentumPlan`.

    Attributes:
        time: Start, s.
        unloads: Time from there in which the external actuator works, s.
        momentum: Total momentum after it, inertial axes, (3,), N·m·s.
        null_space: Null-space momentum z, N·m·s.
        window: Time interval of the science window that it serves, s.
    """

    time: float
    unloads: float
    momentum: Vector
    null_space: float
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
            total=demand.total / unit, wheels=demand.wheels / unit, level=demand.level / unit
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
    point, _ = solve(sufficient(demand, limits, clearance), cost_of(demand, limits), seconds)
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
    entries, count = [], len(demand.windows)
    for window, value in zip(demand.windows, point[: 4 * count].reshape(-1, 4), strict=True):
        begin, end = (float(demand.time[at]) for at in (window.before, window.begin))
        entries.append(
            Entry(
                begin,
                end - begin,
                unit * (demand.total[window.begin] + value[:3]),
                unit * float(value[3]),
                (end, float(demand.time[window.end - 1])),
            )
        )
    changes = np.diff(point[: 4 * count].reshape(-1, 4)[:, :3], axis=0, prepend=np.zeros((1, 3)))
    return Plan(FOUND, tuple(entries), unit * float(np.sum(np.abs(changes))))


def crossings(speed: Matrix, inside: Any, bands: Matrix) -> dict[str, int]:
    """Crossings of zero speed, and entries into bands, within science windows.

    A wheel that is in a band when a window begins has entered it.

    Args:
        speed: Wheel speeds, (samples, wheels), rad/s.
        inside: Whether each sample is in a science window, (samples,).
        bands: Bands of speeds of either sign, (bands, 2), rad/s.

    Returns:
        "zero" and "band": numbers of crossings and of entries.
    """
    inside = np.asarray(inside)
    together = inside[1:] & inside[:-1]
    sense = np.sign(speed)
    passed = (sense[1:] != sense[:-1]) & (sense[:-1] != 0.0)
    entered = 0
    for low, high in bands:
        within = (np.abs(speed) > low) & (np.abs(speed) < high) & inside[:, None]
        before = np.vstack([np.zeros((1, speed.shape[1]), bool), within[:-1]])
        entered += int(np.sum(within & ~before))
    return {"zero": int(np.sum(passed & together[:, None])), "band": entered}
