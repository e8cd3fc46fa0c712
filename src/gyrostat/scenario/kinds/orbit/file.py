"""Orbit from a file of positions and velocities."""

from collections.abc import Mapping
from dataclasses import dataclass

from gyrostat.scenario.orbit_kind import OrbitKind
from gyrostat.spacecraft.orbit.orbit_file import OrbitFile


@dataclass(frozen=True, eq=False)
class File(OrbitKind):
    """Positions and velocities from `file`: CCSDS OEM or CSV.

    A CSV has time, s, position, m, and velocity, m/s, in the `frame` GCRS (default), EME2000, TEME
    or ITRF.
    """

    name = "file"
    texts = ("epoch", "file", "frame")

    def elements(self, texts: Mapping[str, str]) -> OrbitFile:
        """See `OrbitKind.elements`."""
        return OrbitFile.read(texts["elements"], texts["frame"])
