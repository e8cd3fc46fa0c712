"""Pointing at a place on the ground."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import GroundTarget
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.aimed_kind import AimedKind
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.scenario.schema import Key, between_poles


@dataclass(frozen=True, eq=False)
class GroundTargetKind(AimedKind):
    """Pointing at a ground target along [orbit] (`gyrostat.control.guidance.GroundTarget`).

    It is also followed below the horizon.
    """

    name = "ground_target"
    latitude: Annotated[Scalar, between_poles("Geodetic latitude (WGS 84).")]
    longitude: Annotated[Scalar, Key("angle", None, "Longitude, to the east.")]
    height: Annotated[Scalar, Key("length", 0.0, "Height above the ellipsoid.")]

    def target(self, planned: PlannedReference, place: str) -> GroundTarget:
        """See `AimedKind.target`."""
        return GroundTarget(self.latitude, self.longitude, self.height)
