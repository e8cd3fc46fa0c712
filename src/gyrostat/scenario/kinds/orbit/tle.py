"""Orbit from two-line elements."""

from collections.abc import Mapping
from dataclasses import dataclass

from gyrostat.scenario.orbit_kind import OrbitKind
from gyrostat.spacecraft.orbit.two_line_elements import TwoLineElements


@dataclass(frozen=True, eq=False)
class Tle(OrbitKind):
    """Two-line elements by SGP4, from `file` or the text `lines`.

    The epoch of the run is that of the elements by default.
    """

    name = "tle"
    texts = ("epoch", "file", "lines")

    def elements(self, texts: Mapping[str, str]) -> TwoLineElements:
        """See `OrbitKind.elements`."""
        return TwoLineElements.read(texts["elements"], "key orbit")
