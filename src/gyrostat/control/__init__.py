"""Controllers of the loop: from a measurement to motor currents or torques."""

from gyrostat.control.attitude_pid import AttitudePID, CurrentMode
from gyrostat.control.command import CurrentCommand
from gyrostat.control.estimating_compensator import EstimatingCompensator
from gyrostat.control.model_compensator import DynamicModelCompensator
from gyrostat.control.momentum_control import (
    FrictionScaleControl,
    FrictionTorqueControl,
    MomentumCommand,
    ProportionalMomentumControl,
)
from gyrostat.control.recovery_zero_momentum import ZeroMomentumRecovery
from gyrostat.control.speed_mode import SpeedMode
from gyrostat.control.two_wheel_sweeps import TwoWheelSweeps

__all__ = [
    "AttitudePID",
    "CurrentCommand",
    "CurrentMode",
    "DynamicModelCompensator",
    "EstimatingCompensator",
    "FrictionScaleControl",
    "FrictionTorqueControl",
    "MomentumCommand",
    "ProportionalMomentumControl",
    "SpeedMode",
    "TwoWheelSweeps",
    "ZeroMomentumRecovery",
]
