"""Pointing at the limb of the Earth."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import Limb
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.aimed_kind import AimedKind
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.scenario.schema import Key, size


@dataclass(frozen=True, eq=False)
class LimbKind(AimedKind):
    """Pointing above the limb of the Earth (`gyrostat.control.guidance.Limb`)."""

    name = "limb"
    tangent_height: Annotated[
        Scalar, size("length", 0.0, "Height of the tangent point above the ellipsoid.")
    ]
    azimuth: Annotated[
        Scalar,
        Key("angle", 0.0, "From ahead about the zenith, toward the orbit normal (to the left)."),
    ]

    def target(self, planned: PlannedReference, place: str) -> Limb:
        """See `AimedKind.target`."""
        return Limb(self.tangent_height, self.azimuth)
