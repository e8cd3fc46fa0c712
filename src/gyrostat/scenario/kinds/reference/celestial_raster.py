"""Lines at a constant rate about a celestial direction."""

from dataclasses import dataclass

from gyrostat.scenario.aimed_kind import RasterKind
from gyrostat.scenario.kinds.reference.celestial import CelestialKind


@dataclass(frozen=True, eq=False)
class CelestialRaster(RasterKind, CelestialKind):
    """Lines at a constant rate about a celestial direction (`gyrostat.control.guidance.Raster`).

    They go along the part of the second direction (by default the velocity) across the line of
    sight.
    """

    name = "celestial_raster"
