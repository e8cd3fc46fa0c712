"""Parts that can be exported without further design."""

from typing import Any

from gyrostat.control import CurrentMode, EstimatingCompensator
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports.compensated_wheel import CompensatedWheel

Part = EstimatingCompensator | CurrentMode | FrictionScaleFilter | CompensatedWheel
"""Part that can be exported without further design."""
_KINDS = {
    EstimatingCompensator: "compensator",
    CurrentMode: "controller",
    FrictionScaleFilter: "estimator",
    CompensatedWheel: "compensated-wheel",
}


def part_kind(part: Any) -> str | None:
    """Key of a part in `gyrostat.exports.TARGETS`; None for anything else, such as a wheel."""
    return _KINDS.get(type(part))
