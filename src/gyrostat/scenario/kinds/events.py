"""Kinds of events of this package, found in their folder."""

from collections.abc import Iterable, Mapping
from typing import TypeVar

from gyrostat.core.classes_of import classes_of
from gyrostat.scenario.event_kind import EventKind
from gyrostat.scenario.kinds import event as folder
from gyrostat.scenario.scenario import Event

Kind = TypeVar("Kind", bound=EventKind)

EVENTS: Mapping[str, type[EventKind]] = {kind.name: kind for kind in classes_of(folder, EventKind)}
"""Name -> kind of event."""


def events_of(events: Iterable[Event], base: type[Kind]) -> list[tuple[Event, type[Kind]]]:
    """Events whose kind is a subclass of a base, each with its kind."""
    pairs = ((event, kind_of(event)) for event in events)
    return [(event, kind) for event, kind in pairs if issubclass(kind, base)]


def kind_of(event: Event) -> type[EventKind]:
    """Kind of an event; of a user-defined one, which changes the plant alone, the base."""
    return EVENTS.get(event.kind, EventKind)
