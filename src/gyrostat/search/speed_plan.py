"""Search for a plan of wheel speeds, and its flight beside the present law."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.campaigns.engine import LANES, fly, fly_nominal
from gyrostat.campaigns.summary import share_bounds
from gyrostat.core.errors import InputError
from gyrostat.core.pictured import PicturedText
from gyrostat.microvibration.sight import LineOfSight
from gyrostat.runs.sight_in_run import SightInRun
from gyrostat.runs.speed_plan.demand import Limits, bands_of, demand_of
from gyrostat.runs.speed_plan.flight import Flight, flight_of
from gyrostat.runs.speed_plan.plan import FOUND, NOT_FOUND, Plan, plan_of
from gyrostat.scenario.scenario import Part, Scenario
from gyrostat.scenario_files.scenario_file import validated
from gyrostat.simulation import Status

SECTION, BAND = "controller.plan", "controller.band"
FLIGHTS = 3
"""Most plans that are flown; each starts from the flight of the one before."""


@dataclass(frozen=True)
class SpeedPlan(PicturedText):
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
        outside_before: Complete runs without any time in the windows by the present law; they
            count neither as clean nor as others.
        outside_after: The same with the plan.
        sight: Motion of the line of sight, whose bands are avoided too; None: not given.
        sight_before: Its root mean square in the windows of each dispersed run by the present law,
            (runs,), rad; NaN if it is not known or the run has no time in them.
        sight_after: The same with the plan.
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
    outside_before: int = 0
    outside_after: int = 0
    sight: LineOfSight | None = None
    sight_before: tuple[float, ...] = ()
    sight_after: tuple[float, ...] = ()

    @property
    def before(self) -> dict[str, int]:
        """Crossings of the nominal run in the windows by the present law: "zero", "band"."""
        return self.present.crossings

    @property
    def after(self) -> dict[str, int] | None:
        """The same with the plan; None without one."""
        return None if self.planned is None else self.planned.crossings

    def probability(
        self, clean: int | None = None, outside: int | None = None
    ) -> tuple[float, float, float]:
        """Share of dispersed runs without a crossing, and its 95 % interval (Clopper-Pearson).

        It is a share of the runs with time in the windows; NaN if there is none.

        Args:
            clean: Number of runs without a crossing; None: that with the plan.
            outside: Number of runs without time in the windows; None: that with the plan.
        """
        clean = self.clean_after if clean is None else clean
        counted = self.runs - (self.outside_after if outside is None else outside)
        return clean / counted if counted else np.nan, *share_bounds(clean, counted)


def search_plan(
    scenario: Scenario,
    windows: Sequence[str],
    clearance: float,
    *,
    runs: int = 0,
    seed: int = 0,
    engine_for: Callable[[Scenario], str],
    sight: SightInRun | None = None,
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
        sight: Motion of the line of sight by the wheels, whose bands are avoided too; or None.
        seconds: Time for each search.

    Raises:
        InputError: The controller is no wheel array, the nominal run ends early, or it enters no
            window.
    """
    motion = None if sight is None else sight.sight
    if motion is not None:
        scenario = with_bands(scenario, motion.bands())
    scenario = planned(scenario, Plan(NOT_FOUND))
    limits = Limits.of(scenario)
    engine, period = engine_for(scenario), scenario.values["run.control_period"]
    history = fly_nominal(scenario, seed, engine)
    present = flight_of(scenario, history, windows, limits, sight)
    if not np.any(present.inside):
        raise InputError(
            f"{scenario.name}: found no time in the windows {', '.join(windows)}, expected some"
        )
    demand = demand_of(history, present.inside, period, limits, scenario.command_delay)
    plan = plan_of(demand, limits, clearance, seconds)
    about = tuple(windows), clearance, limits, present
    result = SpeedPlan(plan.answer, scenario, plan, *about, None, sight=motion)
    if plan.answer != FOUND:
        return result
    engine_with_plan = engine_for(planned(scenario, plan))
    for number in range(FLIGHTS):
        with_plan = planned(scenario, plan)
        history = fly_nominal(with_plan, seed, engine_with_plan)
        flight = flight_of(with_plan, history, windows, limits, sight)
        result = SpeedPlan(NOT_FOUND, with_plan, plan, *about, flight, sight=motion)
        if np.any(flight.inside) and not any(flight.crossings.values()):
            result = replace(result, answer=FOUND)
            break
        if number < FLIGHTS - 1:
            # attitudes and torques of the plan's own flight differ from those of the present law
            demand = demand_of(history, flight.inside, period, limits, scenario.command_delay)
            again = plan_of(demand, limits, clearance, seconds)
            if again.answer != FOUND:
                break
            plan = again
    if result.answer != FOUND or runs == 0:
        return result
    clean, outside, sights = [], [], []
    for each, used in ((scenario, engine), (result.scenario, engine_with_plan)):
        flown = [*_dispersed(each, windows, limits, runs, seed, used, sight)]
        clean.append(sum(is_clean is True for is_clean, _ in flown))
        outside.append(sum(is_clean is None for is_clean, _ in flown))
        sights.append(tuple(rms for _, rms in flown))
    return replace(
        result,
        runs=runs,
        clean_before=clean[0],
        clean_after=clean[1],
        outside_before=outside[0],
        outside_after=outside[1],
        sight_before=sights[0],
        sight_after=sights[1],
    )


def with_bands(scenario: Scenario, bands: Sequence[tuple[float, float]]) -> Scenario:
    """Scenario with further bands of wheel speeds to avoid, in place of those of the same names.

    Args:
        scenario: Scenario.
        bands: Lower and upper end of each, rad/s.
    """
    names = [f"jitter_{number}" for number in range(1, len(bands) + 1)]
    parts = [p for p in scenario.parts if (p.section, p.name) not in {(BAND, n) for n in names}]
    values = dict(scenario.values)
    for name, (low, high) in zip(names, bands, strict=True):
        parts.append(Part(BAND, name, "speeds"))
        values |= {f"{BAND}.{name}.above": low, f"{BAND}.{name}.below": high}
    ordered = {key: values[key] for key in sorted(values)}
    return validated(replace(scenario, parts=tuple(parts), values=ordered))


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


def _dispersed(
    scenario: Scenario,
    windows: Sequence[str],
    limits: Limits,
    runs: int,
    seed: int,
    engine: str,
    sight: SightInRun | None,
) -> Iterator[tuple[bool | None, float]]:
    """Whether each dispersed run is complete without a crossing, and its line of sight, rad.

    None: it is complete, without any time in the windows.
    """
    for start in range(0, runs, LANES):
        numbers = range(start, min(start + LANES, runs))
        flown = fly(scenario, seed, numbers, keep=numbers, engine=engine)
        assert flown.histories is not None
        for row, number in enumerate(numbers):
            history = flown.histories.of_run(number).arrays()
            drawn = {key: float(flown.columns[key][row]) for key in scenario.dispersed}
            bands = bands_of(scenario, {**scenario.values, **drawn})
            own = limits._replace(bands=bands)
            flight = flight_of(scenario, history, windows, own, sight, drawn)
            if int(flown.columns["status"][row]) != Status.COMPLETE:
                yield False, np.nan
            elif np.any(flight.inside):
                yield not any(flight.crossings.values()), flight.sight
            else:
                yield None, np.nan
