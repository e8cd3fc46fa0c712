"""Mosaic of tiles about a place on the ground."""

from dataclasses import dataclass

from gyrostat.scenario.aimed_kind import MosaicKind
from gyrostat.scenario.kinds.reference.ground_target import GroundTargetKind


@dataclass(frozen=True, eq=False)
class GroundMosaic(MosaicKind, GroundTargetKind):
    """Tiles about a ground target, with a dwell time in each (`gyrostat.control.guidance.Mosaic`).

    Rows go along the part of the second direction (by default the velocity) across the line of
    sight.
    """

    name = "ground_mosaic"
