"""Friction compensation, alone and with the wheel."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from gyrostat.verbs.exported_part import CURRENT_LIMIT, GAINS, SPEED_SIGMA, ExportedPart, Given

if TYPE_CHECKING:
    from gyrostat.control import FieldLimits
    from gyrostat.exports import Target
    from gyrostat.wheel import Wheel


class Compensator(ExportedPart):
    """Friction compensation with a Kalman filter."""

    name = "compensator"
    needs = (GAINS, "--table-inertia", SPEED_SIGMA)
    takes = (CURRENT_LIMIT, "--delay")
    fields: ClassVar[Mapping[str, str]] = {"attitude": "angle", "rate": "speed", "speed": "speed"}

    @classmethod
    def type(cls) -> type:
        """See `ExportedPart.type`."""
        from gyrostat.control import EstimatingCompensator

        return EstimatingCompensator

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> Any:
        """See `ExportedPart.design`."""
        from gyrostat.control import EstimatingCompensator
        from gyrostat.core.validation import check_parts

        limit, law = given.current_limit(), given.law()
        part = EstimatingCompensator.tune(
            law,
            wheel,
            given.si("--table-inertia", "inertia"),
            given.si(SPEED_SIGMA, "speed"),
            period,
            current_limit=limit,
            delay=int(given.values["--delay"] or 0),
        )
        check_parts(part)
        return part

    @classmethod
    def module(
        cls, part: Any, period: float, limits: "Mapping[str, FieldLimits]", on_bad: str
    ) -> "Target":
        """See `ExportedPart.module`."""
        from gyrostat.exports.targets import compensator

        return compensator(part, period, limits, on_bad)


class CompensatedWheelPart(Compensator):
    """Wheel with its compensator, for simulation."""

    name = "compensated-wheel"

    @classmethod
    def type(cls) -> type:
        """See `ExportedPart.type`."""
        from gyrostat.exports import CompensatedWheel

        return CompensatedWheel

    @classmethod
    def design(cls, wheel: "Wheel", period: float, given: Given) -> Any:
        """See `ExportedPart.design`."""
        from gyrostat.exports import CompensatedWheel

        return CompensatedWheel(super().design(wheel, period, given), wheel)

    @classmethod
    def module(
        cls, part: Any, period: float, limits: "Mapping[str, FieldLimits]", on_bad: str
    ) -> "Target":
        """See `ExportedPart.module`."""
        from gyrostat.exports.targets import compensated_wheel

        return compensated_wheel(part, period, limits, on_bad)
