"""Slews of a scenario around keep-out cones, planned once from its nominal values."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from gyrostat.codegen.evaluation import evaluated
from gyrostat.control.guidance import (
    AttitudeReference,
    Condition,
    Fixed,
    PlannedTurns,
    Profile,
    Reference,
    SlewLimits,
    Slews,
    Transition,
    reference_at,
)
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.runs.build import Setup
from gyrostat.runs.build_parts import named_parts
from gyrostat.runs.build_reference import reference_case
from gyrostat.runs.designs import Plans
from gyrostat.runs.followed import TakenChange, taken_changes
from gyrostat.runs.slew_planner import TIMES, SlewPlanner, SlewToPlan
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.orbits import nominal_orbit
from gyrostat.scenario.mode_graph import pairs_around
from gyrostat.scenario.reference_kind import AROUND, Slewing
from gyrostat.scenario.scenario import KEEP_OUT, Scenario
from gyrostat.scenario.structure import structure_of
from gyrostat.scenario.timeline import modes

STEADY = 0.02
"""Largest change of target and rotation of a slew that may start at any time, rad."""
_TIMES = {
    "reference.slew": ("time",),
    "reference.mode": ("until_time", "minimum_dwell"),
    "reference.transition": ("at", "time_in_mode", "held"),
}
"""Keys of times that start a slew, or end the one before it."""


def with_planned_slews(scenario: Scenario, plans: Plans, setup: Setup) -> Plans:
    """Plans of a scenario with those of its slews around cones.

    Args:
        scenario: Scenario.
        plans: Plans without them.
        setup: Parts of the nominal run by these plans.

    Raises:
        InputError: A slew cannot be planned, or a key that plans are made from is dispersed.
    """
    if plans.reference is None or plans.reference.turns is None:
        return plans
    structure, values, orbit = structure_of(scenario), scenario.values, nominal_orbit(scenario)
    kind, case = reference_case(structure, values, plans, setup.start, setup.starts, orbit)
    keep_outs = named_parts(structure, values, KEEP_OUT, Context(orbit=orbit))
    margins = float(kind.keep_out_margin), float(kind.crossing_time)
    planner = SlewPlanner(kind.limits(case), keep_outs, *margins)
    assert setup.reference is not None
    slews = setup.reference.modes[0]
    if isinstance(slews, Slews):
        turns = _plan_slews(scenario, planner, slews, case.slews)
    else:
        turns = _plan_modes(scenario, planner, setup.reference, setup.start.wheel_speed)
    plans = plans._replace(reference=plans.reference._replace(turns=turns))
    planned = keys_of_plans(scenario, plans)
    for key in scenario.dispersed:
        if key in planned:
            raise InputError(
                f"key dispersion: found {key}, expected no dispersion of it: slews with {AROUND} "
                "are planned once, from nominal values"
            )
    return plans


def keys_of_plans(scenario: Scenario, plans: Plans) -> frozenset[str]:
    """Keys that must have their nominal values in each run; empty if no slew is planned.

    These are the limits of slews and the times that start them. With other limits, a run would
    still have the planned rate; at another time, a body can be in the way, or the slew before can
    still turn.

    Args:
        scenario: Scenario.
        plans: Its plans, with those of its slews around cones.
    """
    turns = None if plans.reference is None else plans.reference.turns
    if turns is None or not np.any(turns.is_planned):
        return frozenset()
    names = [*map("reference.{}".format, Slewing.keys())]
    for part in scenario.parts:
        place = f"{part.section}.{part.name}"
        names += [f"{place}.{name}" for name in _TIMES.get(part.section, ())]
    return frozenset(names)


def _plan_slews(
    scenario: Scenario, planner: SlewPlanner, slews: Slews, rows: Sequence[Any]
) -> PlannedTurns:
    """Plans of slews between fixed attitudes, each from its time on."""
    parts = [part for part in scenario.parts if part.section == "reference.slew"]
    turns, before, origin = PlannedTurns.none(len(parts)), slews.attitude, "the initial attitude"
    ends = np.array(slews.ends())
    for row, (part, slew) in enumerate(zip(parts, rows, strict=True)):
        after, start = rotations.normalised(jnp.asarray(slew.target)), float(slews.times[row])
        place = f"reference.slew.{part.name}"
        if part.linked(AROUND):
            zero = jnp.zeros(3)
            still = [AttitudeReference(jnp.asarray(q), zero, zero) for q in (before, after)]
            eigenaxis = _transition(still[0], still[1], np.asarray(start), planner.limits)
            names = part.linked(AROUND)
            turn, _ = planner.plan(
                SlewToPlan(place, origin, names, eigenaxis, Fixed(after), start, start)
            )
            turns = turns.planned(row, turn)
            ends[row] = start + float(turn.profile.duration)
        if row and start < ends[row - 1] and np.any(turns.is_planned[row - 1 : row + 1]):
            raise InputError(
                f"key {place}.time: found {start:g} s, expected the end of the slew before, "
                f"{ends[row - 1]:.1f} s, or later: one of both has {AROUND}"
            )
        before, origin = after, part.name
    return turns


def _plan_modes(
    scenario: Scenario, planner: SlewPlanner, reference: Reference, speed: Any
) -> PlannedTurns:
    """Plans of the slews from mode to mode, in the order in which the nominal reference comes."""
    names, period = modes(scenario.parts), scenario.values["run.control_period"]
    pairs = pairs_around(scenario)
    turns = reference.planned
    assert turns is not None
    while pairs:
        planned = replace(reference, planned=turns)
        every = taken_changes(planned, jnp.asarray(speed), period, scenario.count)
        change = next((each for each in every if each.pair in pairs), None)
        pair = next(iter(pairs)) if change is None else change.pair
        part = pairs.pop(pair)
        first = 0.0 if change is None else change.start
        slew = _known(planned, every, change, planner) or _at_any_time(
            planned, pair, (first, scenario.duration), planner
        )
        if slew is not None:
            place, origin = f"reference.mode.{part.name}", names[pair[0]]
            slew = slew._replace(place=place, origin=origin, instruments=part.linked(AROUND))
            turns = turns.planned(pair[0] * len(names) + pair[1], *planner.plan(slew))
    return turns


def _known(
    reference: Reference,
    every: Sequence[TakenChange],
    change: TakenChange | None,
    planner: SlewPlanner,
) -> SlewToPlan | None:
    """Slew whose time and motion at the start are known before the run; None: they are not.

    The time is known if no change before depends on a measurement, but for those before a change
    that waits for a time of the run or for a view along the orbit.
    """
    if change is None or sum(each.pair == change.pair for each in every) > 1:
        return None
    conditions, is_known = reference.changes.conditions, True
    for each in every[: every.index(change) + 1]:
        of = Condition(*(np.asarray(field)[each.number] for field in conditions))
        is_measured = bool(of.needs_measurement) or reference.changes.user[each.number] is not None
        is_known = not is_measured and (is_known or bool((of.at >= 0.0) | (of.view != 0.0)))
    if not is_known:
        return None
    target = reference.modes[change.to]
    after = jax.tree.map(lambda each: each[0], _motion(target, np.array([change.start])))
    eigenaxis = _transition(change.before, after, np.asarray(change.start), planner.limits)
    return SlewToPlan("", "", (), eigenaxis, target, change.start, change.start)


def _at_any_time(
    reference: Reference, pair: tuple[int, int], times: tuple[float, float], planner: SlewPlanner
) -> SlewToPlan | None:
    """Slew that may start at any time, between attitudes that stay; None: they do not stay."""
    grid: Any = np.linspace(*times, TIMES)
    before, after = (_motion(reference.modes[k], grid) for k in pair)
    middle = TIMES // 2
    offset = jax.vmap(rotations.error)(before.attitude, after.attitude)
    changes = [
        np.max(jax.vmap(rotations.error_angle, (0, None))(each, each[middle]))
        for each in (offset, after.attitude)
    ]
    if max(changes) > STEADY:
        return None
    ends = [jax.tree.map(lambda each: each[middle], motion) for motion in (before, after)]
    eigenaxis = _transition(ends[0], ends[1], np.asarray(grid[middle]), planner.limits)
    return SlewToPlan("", "", (), eigenaxis, reference.modes[pair[1]], *times, float(changes[0]))


@evaluated
def _transition(
    before: AttitudeReference, after: AttitudeReference, start: Any, limits: SlewLimits
) -> Transition:
    """Transition without a plan."""
    return Transition.of(before, after, start, limits)


@evaluated
def _motion(mode: Profile, times: Any) -> AttitudeReference:
    """Motion of a mode at each time."""
    return jax.vmap(partial(reference_at, mode))(jnp.asarray(times))
