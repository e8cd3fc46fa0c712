"""Events, slews and modes of a scenario, from which the times of windows are counted."""

from collections.abc import Iterable

from gyrostat.core.errors import InputError
from gyrostat.scenario.kinds.events import kind_of
from gyrostat.scenario.scenario import Components, Event, Part, Scenario

TRANSITION = "reference.transition"
"""Section of the transitions from mode to mode."""
END_OF_MODE = "until_"
"""Start of the name of a change of mode by the end of a mode."""


def modes(parts: Iterable[Part]) -> list[str]:
    """Names of the modes of the reference, in their order."""
    return [part.name for part in parts if part.section == "reference.mode"]


def branches(parts: Iterable[Part]) -> bool:
    """Whether modes can change by a [[reference.transition]]."""
    return any(part.section == TRANSITION for part in parts)


def change_names(parts: Iterable[Part]) -> list[str]:
    """Names of the changes of mode, in the order of their numbers: transitions, then ends."""
    every = list(parts)
    transitions = [part.name for part in every if part.section == TRANSITION]
    return [*transitions, *(f"{END_OF_MODE}{mode}" for mode in modes(every)[:-1])]


def mode_names(scenario: Components) -> tuple[list[str], list[str]]:
    """Names of the modes, and of the changes of mode."""
    return modes(scenario.parts), change_names(scenario.parts)


def event_times(events: Iterable[Event], parts: Iterable[Part]) -> dict[str, str]:
    """Name of an event, or of a slew of the reference -> key of its time."""
    slews = {part.name: _key(part) for part in parts if part.section == "reference.slew"}
    return slews | {event.name: f"event.{event.name}.time" for event in events}


def slew_times(events: Iterable[Event], parts: Iterable[Part]) -> list[str]:
    """Keys of the times of all slews."""
    slews = [_key(part) for part in parts if part.section == "reference.slew"]
    return slews + [f"event.{event.name}.time" for event in events if kind_of(event).changes_target]


def check_windows(scenario: Scenario) -> None:
    """Validate that events and modes of the windows exist; raises `InputError`."""
    origins = {"event": event_times(scenario.events, scenario.parts), "mode": modes(scenario.parts)}
    for window in scenario.windows:
        for kind, names in origins.items():
            name = getattr(window, kind)
            if name is not None and name not in names:
                raise InputError(
                    f"key metrics.window[{window.name}].{kind}: found {name!r}, expected "
                    f"{'one of ' + ', '.join(names) if names else 'none'}"
                )


def _key(part: Part) -> str:
    return f"{part.section}.{part.name}.time"
