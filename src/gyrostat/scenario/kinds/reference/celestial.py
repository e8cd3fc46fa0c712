"""Pointing at a celestial direction."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import Celestial
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.aimed_kind import AimedKind
from gyrostat.scenario.reference_kind import PlannedReference
from gyrostat.scenario.schema import Key, between_poles


@dataclass(frozen=True, eq=False)
class CelestialKind(AimedKind):
    """Pointing at a celestial direction (`gyrostat.control.guidance.Celestial`)."""

    name = "celestial"
    right_ascension: Annotated[
        Scalar, Key("angle", None, 'Right ascension (ICRS), such as "18h36m56.3s".')
    ]
    declination: Annotated[Scalar, between_poles('Declination (ICRS), such as "38d47m01s".')]

    def target(self, planned: PlannedReference, place: str) -> Celestial:
        """See `AimedKind.target`."""
        return Celestial(self.right_ascension, self.declination)
