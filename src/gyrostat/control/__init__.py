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
from gyrostat.control.recovery_momentum import MomentumRecovery
from gyrostat.control.speed_mode import SpeedMode
from gyrostat.control.three_axis_law import ThreeAxisLaw
from gyrostat.control.two_wheel_law import TwoWheelLaw
from gyrostat.control.wheel_rate_loop import WheelRateLoop

__all__ = [
    "AttitudePID",
    "CurrentCommand",
    "CurrentMode",
    "DynamicModelCompensator",
    "EstimatingCompensator",
    "FrictionScaleControl",
    "FrictionTorqueControl",
    "MomentumCommand",
    "MomentumRecovery",
    "ProportionalMomentumControl",
    "SpeedMode",
    "ThreeAxisLaw",
    "TwoWheelLaw",
    "WheelRateLoop",
]
