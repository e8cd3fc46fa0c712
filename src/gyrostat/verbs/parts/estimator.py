"""Estimator of speed and friction level."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from gyrostat.verbs.exported_part import SPEED_SIGMA, ExportedPart, Given

if TYPE_CHECKING:
    from gyrostat.control import FieldLimits
    from gyrostat.estimation import FrictionScaleFilter
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel


class Estimator(ExportedPart):
    """Speed and friction level of a wheel from its current and tachometer."""

    name = "estimator"
    needs = (SPEED_SIGMA, "--scale-drift")
    fields: ClassVar[Mapping[str, str]] = {"current": "current", "measured": "speed"}

    @classmethod
    def type(cls) -> type:
        """See `ExportedPart.type`."""
        from gyrostat.estimation import FrictionScaleFilter

        return FrictionScaleFilter

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> "FrictionScaleFilter":
        """See `ExportedPart.design`."""
        from gyrostat.estimation import FrictionScaleFilter

        drift = given.number("--scale-drift")
        return FrictionScaleFilter(wheel, given.si(SPEED_SIGMA, "speed"), drift)

    @classmethod
    def module(
        cls,
        part: "FrictionScaleFilter",
        period: float,
        limits: "Mapping[str, FieldLimits]",
        on_bad: str,
    ) -> "Target":
        """See `ExportedPart.module`."""
        from gyrostat.exports.targets import estimator

        return estimator(part, period, limits, on_bad)
