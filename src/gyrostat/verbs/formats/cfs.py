"""Application for the core Flight System."""

from typing import TYPE_CHECKING

from gyrostat.verbs.arguments import Say
from gyrostat.verbs.export_format import CodeFormat

if TYPE_CHECKING:
    from gyrostat.exports import Target


class FlightApplication(CodeFormat):
    """Application folder for NASA's core Flight System (cFS)."""

    name = "cfs"
    about = "application for NASA's cFS"

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, seek: Say | None
    ) -> dict[str, str]:
        """See `CodeFormat.texts`."""
        from gyrostat.exports.cfs import application

        return application(target, precision, origin, seek)  # pyright: ignore[reportArgumentType]
