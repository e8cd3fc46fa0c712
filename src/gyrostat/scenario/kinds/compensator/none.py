"""Absence of a compensator."""

from gyrostat.scenario.component import NoPart


class NoCompensator(NoPart):
    """No compensator."""

    name = "none"
