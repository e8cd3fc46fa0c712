"""Modes of a scenario as a graph, and what can be proven on it without dynamics."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from typing import NamedTuple

from gyrostat.core.errors import InputError
from gyrostat.scenario.mode_kind import UNTIL
from gyrostat.scenario.reference_kind import AROUND
from gyrostat.scenario.scenario import Part, Scenario
from gyrostat.scenario.timeline import END_OF_MODE, TRANSITION, modes
from gyrostat.scenario.transition_kind import CONDITIONS, PAIRS

TIMES = ("time_in_mode", "at", "tracker_lost", "held")
"""Conditions that do not hold in a run that is shorter."""
FREE = ((-1.0, inf),) * len(PAIRS)
"""Limits of a change that has none."""


class GraphEdge(NamedTuple):
    """Change from one mode to another.

    Attributes:
        name: Name of the change, see `change_names`.
        start: Mode from which it leads.
        to: Mode to which it leads.
        time: Least time that a cycle with it takes, s: of a stay in the mode, or from the time at
            which it was taken before.
        once: Whether it is taken once in a run at most.
        limits: Lower and upper limit of each of `PAIRS`.
        view: View that it waits for, see `Condition.view`.
        late: Condition that does not hold before the end of the run; empty: there is none.
    """

    name: str
    start: str
    to: str
    time: float
    once: bool = False
    limits: tuple[tuple[float, float], ...] = FREE
    view: float = 0.0
    late: str = ""


def edges(scenario: Scenario) -> list[GraphEdge]:
    """Changes between the modes of a scenario, one for each pair of modes."""
    return [*_transitions(scenario), *_ends(scenario)]


def pairs_around(scenario: Scenario) -> dict[tuple[int, int], Part]:
    """Numbers of both modes of each slew around keep-out cones -> the mode to which it leads.

    Raises:
        InputError: No slew leads to a mode that names instruments.
    """
    names = modes(scenario.parts)
    parts = {part.name: part for part in scenario.parts if part.section == "reference.mode"}
    around = {name: part for name, part in parts.items() if part.linked(AROUND)}
    pairs = {
        (names.index(edge.start), names.index(edge.to)): around[edge.to]
        for edge in (edges(scenario) if around else [])
        if edge.to in around
    }
    for name, part in around.items():
        if part not in pairs.values():
            raise InputError(
                f"key reference.mode.{name}.{AROUND}: found it in a mode to which no slew leads, "
                "expected a mode that follows another one"
            )
    return pairs


def _transitions(scenario: Scenario) -> Iterator[GraphEdge]:
    names = modes(scenario.parts)
    for part in scenario.parts:
        if part.section != TRANSITION:
            continue
        place = f"{TRANSITION}.{part.name}"
        values = {key: scenario.values[f"{place}.{key}"] for key in CONDITIONS}
        (to,) = part.linked("to")
        for start in part.linked("from") or [name for name in names if name != to]:
            dwell = scenario.values[f"reference.mode.{start}.minimum_dwell"]
            time = max(values["time_in_mode"], values["held"], dwell)
            times = {**{key: values[key] for key in TIMES}, f"minimum_dwell of {start}": dwell}
            limits = tuple((values[f"{n}_above"], values[f"{n}_below"]) for n in PAIRS)
            once, view = values["at"] >= 0.0, values["when"]
            late = _too_late(times, scenario.duration)
            yield GraphEdge(part.name, start, to, time, once, limits, view, late)


def _ends(scenario: Scenario) -> Iterator[GraphEdge]:
    names = modes(scenario.parts)
    for start, to in pairwise(names):
        place = f"reference.mode.{start}"
        values = {key: scenario.values[f"{place}.{key}"] for key in UNTIL}
        if any(values[key] != entry.default for key, entry in UNTIL.items()):
            times = {n: scenario.values[f"{place}.{n}"] for n in ("until_time", "minimum_dwell")}
            limits = tuple(
                (values.get(f"until_{n}_above", -1.0), values.get(f"until_{n}_below", inf))
                for n in PAIRS
            )
            edge = GraphEdge(f"{END_OF_MODE}{start}", start, to, max(times.values()))
            late = _too_late(times, scenario.duration)
            yield edge._replace(limits=limits, view=values["until"], late=late)


def _too_late(times: Mapping[str, float], duration: float) -> str:
    """First of the times that is after the end of the run; empty: there is none."""
    late = [f"{name} {time:g} s" for name, time in times.items() if time > duration]
    return f"{late[0]} in a run of {duration:g} s" if late else ""


def check_modes(scenario: Scenario) -> str:
    """Check the graph of the modes, and say what was proven; empty without several modes.

    Conditions are taken as free signals: this is no proof that the spacecraft reaches a mode.

    Raises:
        InputError: A mode has no path from the first one; or a
            cycle of modes can take no time.
    """
    names, every = modes(scenario.parts), edges(scenario)
    if len(names) < 2 and not every:
        return ""
    reached = _reached(names[0], every)
    for name in names:
        if name not in reached:
            raise InputError(
                f"key reference.mode.{name}: found no path to it from the first mode, {names[0]}, "
                "expected a [[reference.transition]] or an `until` that leads to it"
            )
    cycle = cycle_of([edge for edge in every if edge.time == 0.0 and not edge.once])
    if cycle:
        raise InputError(
            f"key reference.mode.{cycle[0]}: found modes that can follow each other in no time, "
            f"{' -> '.join(cycle)}, expected minimum_dwell, held or time_in_mode in one of them, "
            "or conditions that cannot all hold at one time"
        )
    left = {edge.start for edge in every if edge.to != edge.start}
    final = [name for name in names if name not in left]
    return (
        f"modes: {len(names)}, changes: {len(every)}, final: {', '.join(final) or 'none'}; each "
        "mode has a path from the first one, each that is not final an exit, and no cycle takes "
        "no time (on the graph, with conditions as free signals; this does not say that the "
        "spacecraft reaches them)"
    )


def late_changes(scenario: Scenario) -> list[str]:
    """Lines on the changes of mode that are not taken before the end of the nominal run."""
    late = dict.fromkeys((place_of(edge), edge.late) for edge in edges(scenario) if edge.late)
    return [
        f"warning: {place}: found {time}, expected less: not taken in the nominal run"
        for place, time in late
    ]


def place_of(edge: GraphEdge) -> str:
    """Section of a change in the scenario file."""
    is_end = edge.name.startswith(END_OF_MODE)
    return f"reference.mode.{edge.start}" if is_end else f"{TRANSITION}.{edge.name}"


def _reached(start: str, every: Sequence[GraphEdge]) -> set[str]:
    """Modes that have a path from a mode."""
    reached, waiting = {start}, [start]
    while waiting:
        mode = waiting.pop()
        later = {edge.to for edge in every if edge.start == mode} - reached
        reached |= later
        waiting += later
    return reached


def hold_together(changes: Sequence[GraphEdge]) -> bool:
    """Whether the limits and views of changes can hold at one time; equal limits count as such."""
    views = {each.view for each in changes} - {0.0}
    if any(-view in views for view in views):
        return False
    return all(
        max(low for low, _ in pair) <= min(high for _, high in pair)
        for pair in zip(*(each.limits for each in changes), strict=True)
    )


def cycle_of(every: Sequence[GraphEdge]) -> list[str]:
    """Modes of a cycle whose changes can all be taken at one time; empty: there is none."""
    for edge in every:
        waiting: list[tuple[GraphEdge, ...]] = [(edge,)]
        known: set[object] = set()
        while waiting:
            path = waiting.pop(0)
            if path[-1].to == edge.start:
                return [edge.start, *(each.to for each in path)]
            for other in every:
                longer = (*path, other)
                # what a path excludes is all that its continuation depends on
                state = other.to, frozenset((each.limits, each.view) for each in longer)
                if other.start == path[-1].to and state not in known and hold_together(longer):
                    known.add(state)
                    waiting.append(longer)
    return []
