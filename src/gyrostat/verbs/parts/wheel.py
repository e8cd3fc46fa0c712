"""The wheel itself."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from gyrostat.verbs.exported_part import ExportedPart, Given

if TYPE_CHECKING:
    from gyrostat.control import FieldLimits
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel


class WheelPart(ExportedPart):
    """Wheel with its dry friction, for simulation."""

    name = "wheel"

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> "Wheel":
        """See `ExportedPart.design`."""
        return wheel

    @classmethod
    def module(
        cls, part: "Wheel", period: float, limits: "Mapping[str, FieldLimits]", on_bad: str
    ) -> "Target":
        """See `ExportedPart.module`."""
        from gyrostat.exports.targets import wheel

        return wheel(part, period)
