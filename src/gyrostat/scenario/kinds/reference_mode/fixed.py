"""Fixed attitude as a mode."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import Fixed
from gyrostat.core.arrays import Quaternion
from gyrostat.core.rotations import normalised
from gyrostat.scenario.reference_kind import TARGET, PlannedReference, ProfileKind


@dataclass(frozen=True, eq=False)
class FixedMode(ProfileKind):
    """Fixed attitude."""

    name = "fixed"
    target: Annotated[Quaternion, TARGET]

    def profile(self, planned: PlannedReference, place: str) -> Fixed:
        """See `ProfileKind.profile`."""
        return Fixed(normalised(self.target))
