"""Mosaic of tiles about a celestial direction."""

from dataclasses import dataclass

from gyrostat.scenario.aimed_kind import MosaicKind
from gyrostat.scenario.kinds.reference.celestial import CelestialKind


@dataclass(frozen=True, eq=False)
class CelestialMosaic(MosaicKind, CelestialKind):
    """Tiles about a celestial direction, with a dwell time in each.

    See `gyrostat.control.guidance.Mosaic`. Rows go along the part of the second direction (by
    default the velocity) across the line of sight.
    """

    name = "celestial_mosaic"
