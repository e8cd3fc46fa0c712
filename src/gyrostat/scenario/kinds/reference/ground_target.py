"""Pointing at a place on the ground."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import GroundTarget, Pointing
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import ORBIT
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind
from gyrostat.scenario.schema import Key, vector


@dataclass(frozen=True, eq=False)
class GroundTargetKind(ProfileKind):
    """Pointing at a ground target along [orbit] (`gyrostat.control.guidance.GroundTarget`).

    It is also followed below the horizon.
    """

    name = "ground_target"
    needs = frozenset({ORBIT})
    latitude: Annotated[Scalar, Key("angle", None, "Geodetic latitude (WGS 84).")]
    longitude: Annotated[Scalar, Key("angle", None, "Longitude, to the east.")]
    height: Annotated[Scalar, Key("length", 0.0, "Height above the ellipsoid.")]
    to_target: Annotated[
        Vector3, vector("1", "Body axis that points to the target.", (0.0, 0.0, 1.0))
    ]
    along: Annotated[
        Vector3,
        vector(
            "1",
            "Body axis whose part across `to_target` points along the velocity.",
            (1.0, 0.0, 0.0),
        ),
    ]

    def profile(self, planned: PlannedReference, place: str) -> Pointing:
        """See `ProfileKind.profile`."""
        target = GroundTarget(self.latitude, self.longitude, self.height)
        return planned.pointing(target, self.to_target, self.along)
