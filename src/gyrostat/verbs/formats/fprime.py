"""Component for F Prime."""

from typing import TYPE_CHECKING

from gyrostat.verbs.export_format import CodeFormat

if TYPE_CHECKING:
    from gyrostat.exports import Search, Target


class FlightComponent(CodeFormat):
    """Component for NASA's F Prime: a model in FPP, and C++."""

    name = "fprime"
    about = "component for F Prime"

    @classmethod
    def texts(
        cls, target: "Target", precision: str, origin: str, search: "Search | None"
    ) -> dict[str, str]:
        """See `CodeFormat.texts`."""
        from gyrostat.exports.fprime import component

        return component(target, precision, origin, search)  # pyright: ignore[reportArgumentType]
