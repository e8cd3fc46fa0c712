"""Flight code in C."""

from typing import TYPE_CHECKING

from gyrostat.verbs.arguments import Say
from gyrostat.verbs.export_format import CodeFormat

if TYPE_CHECKING:
    from gyrostat.exports import Target


class FlightCode(CodeFormat):
    """Flight folder in C."""

    name = "c"
    about = "flight code"

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, seek: Say | None
    ) -> dict[str, str]:
        """See `CodeFormat.texts`."""
        from gyrostat.exports import files

        return files(target, precision, origin, seek)  # pyright: ignore[reportArgumentType]
