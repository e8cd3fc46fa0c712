"""Attitude law alone."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from gyrostat.verbs.exported_part import CURRENT_LIMIT, GAINS, ExportedPart, Given

if TYPE_CHECKING:
    from gyrostat.control import CurrentMode, FieldLimits
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel


class Controller(ExportedPart):
    """Attitude law of one axis, which commands a motor current."""

    name = "controller"
    needs = (GAINS,)
    takes = (CURRENT_LIMIT,)
    fields: ClassVar[Mapping[str, str]] = {"attitude": "angle", "rate": "speed"}

    @classmethod
    def type(cls) -> type:
        """See `ExportedPart.type`."""
        from gyrostat.control import CurrentMode

        return CurrentMode

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> "CurrentMode":
        """See `ExportedPart.design`."""
        from gyrostat.control import CurrentMode

        limit = given.current_limit()
        return CurrentMode(given.law(), wheel.motor_constant, limit)

    @classmethod
    def module(
        cls, part: "CurrentMode", period: float, limits: "Mapping[str, FieldLimits]", on_bad: str
    ) -> "Target":
        """See `ExportedPart.module`."""
        from gyrostat.exports.targets import controller

        return controller(part, period, limits, on_bad)
