"""Absence of an unloading."""

from gyrostat.scenario.component import NoPart


class NoUnloading(NoPart):
    """No unloading in addition to that of the controller."""

    name = "none"
