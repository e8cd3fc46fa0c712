"""Application for the core Flight System."""

from typing import TYPE_CHECKING

from gyrostat.verbs.export_format import CodeFormat

if TYPE_CHECKING:
    from gyrostat.exports import Search, Target


class FlightApplication(CodeFormat):
    """Application folder for NASA's core Flight System (cFS)."""

    name = "cfs"
    about = "application for NASA's cFS"

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, search: "Search | None"
    ) -> dict[str, str]:
        """See `CodeFormat.texts`."""
        from gyrostat.exports.cfs import application

        return application(target, precision, origin, search)  # pyright: ignore[reportArgumentType]
