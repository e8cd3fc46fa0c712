"""Parts that can be exported without further design."""

from gyrostat.control import CurrentMode, EstimatingCompensator
from gyrostat.estimation import FrictionScaleFilter
from gyrostat.exports.compensated_wheel import CompensatedWheel

Part = EstimatingCompensator | CurrentMode | FrictionScaleFilter | CompensatedWheel
"""Part that can be exported without further design."""
