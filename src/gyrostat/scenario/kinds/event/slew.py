"""Change of the target attitude."""

from dataclasses import dataclass

from gyrostat.scenario.event_kind import EventKind


@dataclass(frozen=True, eq=False)
class Slew(EventKind):
    """The target attitude of the controller changes to `target`."""

    name = "slew"
    affects = "target"
    changes_target = True
