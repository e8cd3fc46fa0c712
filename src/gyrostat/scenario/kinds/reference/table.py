"""Attitude from a table."""

from dataclasses import dataclass

from gyrostat.control.guidance import Table
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind


@dataclass(frozen=True, eq=False)
class TableKind(ProfileKind):
    """Attitude from a CSV `file`, interpolated by a cubic spline.

    Its columns are time, s, and quaternion, scalar first (`gyrostat.control.guidance.Table`).
    """

    name = "table"
    texts = ("file",)

    def profile(self, planned: PlannedReference, place: str) -> Table:
        """See `ProfileKind.profile`."""
        return planned.tables[place]
