"""Change of the target attitude."""

from gyrostat.scenario.event_kind import EventKind


class Slew(EventKind):
    """The target attitude of the controller changes to `target`."""

    name = "slew"
    affects = "target"
    changes_target = True
