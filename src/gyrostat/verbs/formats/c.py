"""Flight code in C."""

from typing import TYPE_CHECKING

from gyrostat.verbs.export_format import CodeFormat

if TYPE_CHECKING:
    from gyrostat.exports import Search, Target


class FlightCode(CodeFormat):
    """Flight folder in C."""

    name = "c"
    about = "flight code"

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, search: "Search | None"
    ) -> dict[str, str]:
        """See `CodeFormat.texts`."""
        from gyrostat.exports import files

        return files(target, precision, origin, search)  # pyright: ignore[reportArgumentType]
