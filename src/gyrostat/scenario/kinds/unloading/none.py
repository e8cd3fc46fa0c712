"""Absence of an unloading."""

from dataclasses import dataclass
from typing import Any

from gyrostat.scenario.component import Context, Kind


@dataclass(frozen=True, eq=False)
class NoUnloading(Kind):
    """No unloading in addition to that of the controller."""

    name = "none"

    def make(self, context: Context) -> Any:
        """The controller itself."""
        return context.controller
