"""Search for a plan of wheel speeds, and its flight beside the present law."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.campaigns.engine import LANES, fly, fly_nominal
from gyrostat.campaigns.summary import share_bounds
from gyrostat.core.errors import InputError
from gyrostat.runs.speed_plan.demand import Limits, demand_of
from gyrostat.runs.speed_plan.flight import Flight, flight_of
from gyrostat.runs.speed_plan.plan import FOUND, NOT_FOUND, Plan, plan_of
from gyrostat.scenario.scenario import Part, Scenario
from gyrostat.scenario_files.scenario_file import validated
from gyrostat.simulation import Status

SECTION = "controller.plan"
FLIGHTS = 3
"""Most plans that are flown; each starts from the flight of the one before."""


@dataclass(frozen=True)
class SpeedPlan:
    """Plan of wheel speeds for the science windows of a scenario.

    Attributes:
        answer: "found": flown without a crossing in the nominal run; "infeasible": proven that no
            control keeps the clearance with these attitudes and external torques and without
            unloading in the windows; "not found": neither.
        scenario: Scenario with the plan; the given one without a plan.
        plan: The plan, or the proof that there is none.
        windows: Names of the science windows.
        clearance: Distance from zero speed, bands and limits, rad/s.
        limits: Wheels, actuator and bands.
        present: Nominal run by the present law.
        planned: Nominal run with the plan; None without one.
        runs: Number of dispersed runs.
        clean_before: Runs without any crossing in the windows by the present law.
        clean_after: The same with the plan.
    """

    answer: str
    scenario: Scenario
    plan: Plan
    windows: tuple[str, ...]
    clearance: float
    limits: Limits
    present: Flight
    planned: Flight | None
    runs: int = 0
    clean_before: int = 0
    clean_after: int = 0

    @property
    def before(self) -> dict[str, int]:
        """Crossings of the nominal run in the windows by the present law: "zero", "band"."""
        return self.present.crossings

    @property
    def after(self) -> dict[str, int] | None:
        """The same with the plan; None without one."""
        return None if self.planned is None else self.planned.crossings

    def probability(self, clean: int | None = None) -> tuple[float, float, float]:
        """Share of dispersed runs without a crossing, and its 95 % interval (Clopper-Pearson).

        Args:
            clean: Number of runs without a crossing; None: that with the plan.
        """
        clean = self.clean_after if clean is None else clean
        return clean / self.runs, *share_bounds(clean, self.runs)


def search_plan(
    scenario: Scenario,
    windows: Sequence[str],
    clearance: float,
    *,
    runs: int = 0,
    seed: int = 0,
    engine_for: Callable[[Scenario], str],
    seconds: float = 20.0,
) -> SpeedPlan:
    """Search for a plan of wheel speeds and fly it.

    Args:
        scenario: Scenario; a plan that it has is not used.
        windows: Names of the science windows.
        clearance: Distance from zero speed, bands and limits, rad/s.
        runs: Number of dispersed runs of the present law and of the plan, with the same draws.
        seed: Seed of all draws.
        engine_for: Engine that simulates a scenario.
        seconds: Time for each search.

    Raises:
        InputError: The controller is no wheel array, the nominal run ends early, or it enters no
            window.
    """
    scenario = planned(scenario, Plan(NOT_FOUND))
    limits = Limits.of(scenario)
    engine, period = engine_for(scenario), scenario.values["run.control_period"]
    history = fly_nominal(scenario, seed, engine)
    present = flight_of(scenario, history, windows, limits)
    if not np.any(present.inside):
        raise InputError(
            f"{scenario.name}: found no time in the windows {', '.join(windows)}, expected some"
        )
    demand = demand_of(history, present.inside, period, limits, scenario.command_delay)
    plan = plan_of(demand, limits, clearance, seconds)
    about = tuple(windows), clearance, limits, present
    if plan.answer != FOUND:
        return SpeedPlan(plan.answer, scenario, plan, *about, None)
    with_plan = planned(scenario, plan)
    engine_with_plan = engine_for(with_plan)
    for number in range(FLIGHTS):
        history = fly_nominal(with_plan, seed, engine_with_plan)
        flight = flight_of(with_plan, history, windows, limits)
        safe = np.any(flight.inside) and not any(flight.crossings.values())
        if safe or number == FLIGHTS - 1:
            break
        # attitudes and torques of the plan's own flight differ from those of the present law
        demand = demand_of(history, flight.inside, period, limits, scenario.command_delay)
        again = plan_of(demand, limits, clearance, seconds)
        if again.answer != FOUND:
            break
        plan, with_plan = again, planned(scenario, again)
    answer = FOUND if safe else NOT_FOUND
    if answer != FOUND or runs == 0:
        return SpeedPlan(answer, with_plan, plan, *about, flight)
    clean = [
        sum(_clean(each, windows, limits, runs, seed, used))
        for each, used in ((scenario, engine), (with_plan, engine_with_plan))
    ]
    return SpeedPlan(answer, with_plan, plan, *about, flight, runs, *clean)


def planned(scenario: Scenario, plan: Plan) -> Scenario:
    """Scenario with a plan in place of its own.

    Args:
        scenario: Scenario.
        plan: Plan; without entries, the scenario has none.
    """
    parts = [part for part in scenario.parts if part.section != SECTION]
    values = {k: v for k, v in scenario.values.items() if not k.startswith(f"{SECTION}.")}
    for name, entry in named_entries(plan):
        parts.append(Part(SECTION, name, "entry"))
        place = f"{SECTION}.{name}"
        values |= {
            f"{place}.time": entry.time,
            f"{place}.unloads": entry.unloads,
            f"{place}.null_space": entry.null_space,
        }
        values |= {
            f"{place}.{key}.{axis}": float(value)
            for key in ("momentum", "momentum_rate", "torque")
            for axis, value in zip("xyz", getattr(entry, key), strict=True)
        }
    ordered = {key: values[key] for key in sorted(values)}
    return validated(replace(scenario, parts=tuple(parts), values=ordered))


def named_entries(plan: Plan) -> Iterator[tuple[str, Any]]:
    """Name and entry of each part of a plan."""
    for number, entry in enumerate(plan.entries, 1):
        yield f"entry_{number}", entry


def _clean(
    scenario: Scenario, windows: Sequence[str], limits: Limits, runs: int, seed: int, engine: str
) -> Iterator[bool]:
    """Whether each dispersed run is complete and has no crossing in the windows."""
    for start in range(0, runs, LANES):
        numbers = range(start, min(start + LANES, runs))
        flown = fly(scenario, seed, numbers, keep=numbers, engine=engine)
        assert flown.histories is not None
        for number, status in zip(numbers, flown.columns["status"], strict=True):
            history = flown.histories.of_run(number).arrays()
            found = flight_of(scenario, history, windows, limits).crossings
            yield int(status) == Status.COMPLETE and not any(found.values())
