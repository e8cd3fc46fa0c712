"""Kinds of events of this package, found in their folder."""

from collections.abc import Mapping

from gyrostat.core.classes_of import classes_of
from gyrostat.scenario.event_kind import EventKind
from gyrostat.scenario.kinds import event as folder
from gyrostat.scenario.scenario import Event

EVENTS: Mapping[str, type[EventKind]] = {kind.name: kind for kind in classes_of(folder, EventKind)}
"""Name -> kind of event."""


def kind_of(event: Event) -> type[EventKind]:
    """Kind of an event; of a user-defined one, which changes the plant alone, the base."""
    return EVENTS.get(event.kind, EventKind)
