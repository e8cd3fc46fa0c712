"""Attitude from a table."""

from dataclasses import dataclass

from gyrostat.control.guidance import Table
from gyrostat.core.errors import InputError
from gyrostat.scenario.attitude_table import attitude_table
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind


@dataclass(frozen=True, eq=False)
class TableKind(ProfileKind):
    """Attitude from a CSV `file`, interpolated by a cubic spline.

    Its columns are time, s, and quaternion, scalar first (`gyrostat.control.guidance.Table`).
    """

    name = "table"
    texts = ("file",)

    @classmethod
    def read_file(cls, where: str, text: str) -> Table:
        """See `ProfileKind.read_file`."""
        return attitude_table(where, text)

    @classmethod
    def check_cover(cls, content: Table, where: str, duration: float) -> None:
        """See `ProfileKind.check_cover`."""
        first, last = content.times[0], content.times[-1]
        if not first <= 0.0 <= duration <= last:
            raise InputError(
                f"{where}: found times from {first:g} s to {last:g} s, expected them to cover the "
                f"run, 0 s to {duration:g} s"
            )

    def profile(self, planned: PlannedReference, place: str) -> Table:
        """See `ProfileKind.profile`."""
        return planned.tables[place]
