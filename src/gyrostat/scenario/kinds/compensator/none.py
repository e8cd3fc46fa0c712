"""Absence of a compensator."""

from dataclasses import dataclass
from typing import Any

from gyrostat.scenario.component import Context, Kind


@dataclass(frozen=True, eq=False)
class NoCompensator(Kind):
    """No compensator."""

    name = "none"

    def make(self, context: Context) -> Any:
        """The controller itself."""
        return context.controller
