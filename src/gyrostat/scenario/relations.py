"""Relations between the values of a scenario that its file must fulfil."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from gyrostat.scenario.kinds.registry import component, named_components
from gyrostat.scenario.relation import Relation, has_direction, less
from gyrostat.scenario.scenario import INERTIA, Scenario
from gyrostat.scenario.structure import measured_names
from gyrostat.scenario.timeline import event_times
from gyrostat.spacecraft.flexible.appendages import APPENDAGES
from gyrostat.spacecraft.flexible.coupling import MODE_STEP
from gyrostat.spacecraft.spacecraft import beyond_rotors, is_positive_definite
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.friction_laws import law_of
from gyrostat.wheel.segment import MAX_SEGMENTS


def relations_of(scenario: Scenario) -> Iterator[Relation]:
    """Relations that the values of a scenario, and of each of its runs, must fulfil."""
    yield _body(scenario)
    yield from _times(scenario)
    yield from _appendages(scenario)
    yield from _limits(scenario)
    for place, section, kind in named_components(scenario):
        part = component(section, kind, scenario.sources)
        directions = (name for name, entry in part.keys().items() if entry.is_direction)
        yield from (has_direction(f"{place}.{name}") for name in directions)
        yield from part.relations(place, scenario)


def nominal_relations(scenario: Scenario) -> Iterator[Relation]:
    """Relations of the nominal values: events, slews and windows are within the run.

    The draws of a campaign need not fulfil them: an event after the end does not happen.
    """
    origins = event_times(scenario.events, scenario.parts)
    for key in ("metrics.after", *origins.values()):
        yield before_end(key)
    for window in scenario.windows:
        origin = None if window.event is None else origins[window.event]
        yield from relations_of_window(window.name, origin)


def relations_of_window(name: str, origin: str | None) -> Iterator[Relation]:
    """Relations of a window.

    Args:
        name: Name of the window.
        origin: Key of the time of its event; None for the start of the run, or a mode.
    """
    keys = [f"window.{name}.{end}" for end in ("from", "until")]
    first, last = keys
    place = f"metrics.window[{name}]"
    origins = () if origin is None else (origin,)

    def remaining(values: Mapping[str, Any]) -> Any:
        return values["run.duration"] - (0.0 if origin is None else values[origin])

    after = "" if origin is None else f" after {{{origin}}} s"
    yield Relation(
        (first, *origins, "run.duration"),
        f"{place}.from: found {{{first}}} s{after}, expected a time before the end of the run, "
        "{run.duration} s",
        lambda values: values[first] < remaining(values),
    )
    yield Relation(
        (last, *origins, "run.duration"),
        f"{place}.until: found {{{last}}} s{after}, expected at most the end of the run, "
        "{run.duration} s",
        lambda values: (values[last] <= remaining(values)) | (values[last] == np.inf),
    )
    yield Relation(
        (first, last),
        f"{place}.until: found {{{last}}} s, expected a time after its start, {{{first}}} s",
        lambda values: values[first] <= values[last],
    )


def before_end(key: str) -> Relation:
    """Relation of a time that is before the end of the run.

    Args:
        key: Key of the time.
    """
    text = f"{key}: found {{{key}}} s, expected a time before the end of the run, "
    return less(key, "run.duration", f"{text}{{run.duration}} s")


def _body(scenario: Scenario) -> Relation:
    """The body is one that can have the rotors; see `check_rotors`."""
    ends = {"".join(sorted(end)): f"body.inertia.{end}" for end in INERTIA}
    rotors = [f"wheel.{wheel}.inertia" for wheel in scenario.wheels]

    def holds(values: Mapping[str, Any]) -> Any:
        inertia = [[values[ends["".join(sorted((a, b)))]] for b in "xyz"] for a in "xyz"]
        spin = [values[key] for key in rotors]
        return is_positive_definite(beyond_rotors(inertia, scenario.axes, spin))

    return Relation(
        (*ends.values(), *rotors),
        "body.inertia: found that of no body with these rotors, expected a possible one",
        holds,
    )


def _times(scenario: Scenario) -> Iterator[Relation]:
    """Faults of sensors end after their start; slews are in their order."""
    for event in scenario.events:
        start, end = (f"event.{event.name}.{name}" for name in ("time", "until"))
        if event.sensor is not None:
            text = f"{end}: found {{{end}}} s, expected a time after its start, {{{start}}} s"
            yield less(start, end, text)
    section = "reference.slew"
    slews = [part.name for part in scenario.parts if part.section == section]
    for before, after in pairwise(f"{section}.{name}.time" for name in slews):
        text = f"{after}: found {{{after}}} s, expected a time after the slew before, "
        yield less(before, after, f"{text}{{{before}}} s")


def _appendages(scenario: Scenario) -> Iterator[Relation]:
    """The explicit integration resolves the modes of flexible appendages.

    The Runge-Kutta steps are shortened to `MODE_STEP` of the phase of a mode, at most
    `MAX_SEGMENTS` of them in a step of the scenario. The integration with bristles is implicit.
    """
    if not issubclass(law_of(scenario.friction, scenario.sources), Friction):
        return
    for part in scenario.parts:
        if part.section in APPENDAGES:
            key = f"{part.section}.{part.name}.frequency"
            yield _resolved(key, scenario.values["run.control_period"] / scenario.substeps)


def _resolved(key: str, step: float) -> Relation:
    """The integration resolves a frequency in steps, s."""
    most = MAX_SEGMENTS * MODE_STEP / (2.0 * np.pi * step)
    text = (
        f"{key}: found {{{key}}} Hz, expected at most {most:g} Hz, what the explicit integration "
        f"resolves in a step of {step:g} s: use a shorter run.step, or leave out the mode"
    )
    return Relation((key,), text, lambda values: values[key] <= most)


def _limits(scenario: Scenario) -> Iterator[Relation]:
    """The limits of the guard have an extent."""
    for name in measured_names(scenario) if scenario.guard is not None else ():
        low, high = (f"guard.{name}_{end}" for end in ("lower", "upper"))
        if low in scenario.values:
            yield less(low, high, f"{high}: found {{{high}}}, expected more than {low}, {{{low}}}")
