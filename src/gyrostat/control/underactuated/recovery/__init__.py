"""Recovery laws: bring a spacecraft to rest in a target attitude with the remaining wheels."""

from gyrostat.control.underactuated.recovery.momentum import MomentumRecovery
from gyrostat.control.underactuated.recovery.one_wheel import OneWheelRecovery
from gyrostat.control.underactuated.recovery.paddle_recovery import PaddleRecovery
from gyrostat.control.underactuated.recovery.two_wheel_sweeps import TwoWheelSweeps
from gyrostat.control.underactuated.recovery.zero_momentum import ZeroMomentumRecovery

__all__ = [
    "MomentumRecovery",
    "OneWheelRecovery",
    "PaddleRecovery",
    "TwoWheelSweeps",
    "ZeroMomentumRecovery",
]
