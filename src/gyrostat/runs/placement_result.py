"""Result of `place`: best directions in body axes, and what they see."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.pictured import Pictured
from gyrostat.core.text import plain, triple
from gyrostat.runs.blind_windows import percent
from gyrostat.runs.body_sky import BodySky
from gyrostat.runs.placement import Blocked, Exclusion, Heads
from gyrostat.runs.reference_path import longest_outage
from gyrostat.runs.surface_placement import Surface


@dataclass(frozen=True, eq=False)
class Placement(Pictured):
    """Best directions in body axes, and what they see.

    Attributes:
        scenario: Name of the scenario.
        attitude: What the attitude is that of: "the reference" or "the nominal run".
        windows: Names of the windows whose time counts; empty: the whole run.
        exclusion: What blinds a head.
        apart: Least angle between two heads, rad.
        blocked: Directions that the body blocks.
        best: Best directions of one head, of two, ....
        present: The same for the heads of the scenario; None without any.
        radiator: Normal of the radiator with the least absorbed heat, W/m².
        panel: Normal of the solar panel with the most sunlight, a share of full sunlight.
        sky: Sun, Earth and Moon in body axes at the times that count.
        step: Time between them, s.
    """

    scenario: str
    attitude: str
    windows: tuple[str, ...]
    exclusion: Exclusion
    apart: float
    blocked: tuple[Blocked, ...]
    best: tuple[Heads, ...]
    present: Heads | None
    radiator: Surface | None
    panel: Surface | None
    sky: BodySky
    step: float

    def lines(self) -> list[str]:
        """The result as lines for a terminal."""
        lines = [f"{self.scenario}: body directions along {self.attitude}, {self.time_that_counts}"]
        lines += [f"  {name}: {text}" for name, text in self.rows()]
        return lines

    def __str__(self) -> str:
        """The lines for a terminal."""
        return "\n".join(self.lines())

    @property
    def time_that_counts(self) -> str:
        """The windows in words."""
        if not self.windows:
            return "whole run"
        return f"window{'s' if len(self.windows) > 1 else ''} {', '.join(self.windows)}"

    def rows(self) -> list[tuple[str, str]]:
        """Name and text of each result."""
        rows = [] if self.present is None else [("heads of the scenario", self._told(self.present))]
        for count, heads in enumerate(self.best, 1):
            rows.append((f"best {count} head{'s' if count > 1 else ''}", self._told(heads)))
        if self.radiator is not None:
            rows.append(
                (
                    "best radiator normal",
                    f"({triple(self.radiator.direction, 3)}): absorbs "
                    f"{plain(self.radiator.mean, 3)} W/m² on average, at most "
                    f"{plain(self.radiator.worst, 3)} W/m²",
                )
            )
        if self.panel is not None:
            rows.append(
                (
                    "best solar panel normal",
                    f"({triple(self.panel.direction, 3)}): {percent(self.panel.mean)} of full "
                    f"sunlight on average, at least {percent(self.panel.worst)} outside of eclipse",
                )
            )
        return rows

    def _told(self, heads: Heads) -> str:
        directions = "; ".join(
            f"({triple(direction, 3)}) sees in {percent(share)}"
            for direction, share in zip(heads.directions, heads.each, strict=True)
        )
        outage = longest_outage(np.any(heads.sees, axis=1), self.step)
        return (
            f"at least one sees in {percent(heads.availability)} of the time, longest outage "
            f"{plain(outage)} s, {heads.in_view:.3g} see on average: {directions}"
        )

    def content(self) -> dict[str, Any]:
        """Content of place.json, SI units and radians."""
        return {
            "scenario": self.scenario,
            "attitude": self.attitude,
            "windows": [*self.windows],
            "exclusion": {
                name: value if np.isfinite(value) else None
                for name, value in self.exclusion._asdict().items()
            },
            "apart": self.apart,
            "blocked": [
                {"direction": cone.direction.tolist(), "angle": cone.angle} for cone in self.blocked
            ],
            "present": None if self.present is None else self._heads(self.present),
            "best": [self._heads(heads) for heads in self.best],
            "radiator": _surface(self.radiator),
            "panel": _surface(self.panel),
        }

    def _heads(self, heads: Heads) -> dict[str, Any]:
        return {
            "directions": heads.directions.tolist(),
            "availability": heads.availability,
            "outage": longest_outage(np.any(heads.sees, axis=1), self.step),
            "in_view": heads.in_view,
            "each": heads.each.tolist(),
        }


def _surface(surface: Surface | None) -> dict[str, Any] | None:
    if surface is None:
        return None
    return {
        "direction": surface.direction.tolist(),
        "mean": surface.mean,
        "worst": surface.worst,
    }
