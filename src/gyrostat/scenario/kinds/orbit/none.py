"""Absence of an orbit."""

from dataclasses import dataclass

from gyrostat.scenario.component import Kind


@dataclass(frozen=True, eq=False)
class NoOrbit(Kind):
    """No orbit."""

    name = "none"
