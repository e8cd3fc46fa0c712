"""Strip on the ground, for a push-broom camera."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import GroundStrip, GroundTarget
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.aimed_kind import AimedKind
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.scenario.schema import Key, between_poles, positive, size


@dataclass(frozen=True, eq=False)
class GroundStripKind(AimedKind):
    """Pointing at a place that moves along the ground (`gyrostat.control.guidance.GroundStrip`)."""

    name = "ground_strip"
    first_latitude: Annotated[Scalar, between_poles("Geodetic latitude of the first end.")]
    first_longitude: Annotated[Scalar, Key("angle", None, "Its longitude, to the east.")]
    last_latitude: Annotated[Scalar, between_poles("Geodetic latitude of the last end.")]
    last_longitude: Annotated[Scalar, Key("angle", None, "Its longitude, to the east.")]
    height: Annotated[Scalar, Key("length", 0.0, "Height of both above the ellipsoid.")]
    begin: Annotated[Scalar, size("time", None, "Time of the run at the first end.")]
    strip_time: Annotated[Scalar, positive("time", None, "Time from the first end to the last.")]

    def target(self, planned: PlannedReference, place: str) -> GroundStrip:
        """See `AimedKind.target`."""
        first = GroundTarget(self.first_latitude, self.first_longitude, self.height)
        last = GroundTarget(self.last_latitude, self.last_longitude, self.height)
        return GroundStrip(first, last, self.begin, self.strip_time)
