"""Reaction wheel with dry friction: parameters, response to a current, and model file."""

from gyrostat.wheel.array import WheelArray
from gyrostat.wheel.axes import orthogonal_axes, pyramid_axes
from gyrostat.wheel.bearing_equation import BearingEquation, Motion
from gyrostat.wheel.bristles import step_bristles, step_wheel
from gyrostat.wheel.coupled_bearings import Changes, CoupledBearings
from gyrostat.wheel.coupled_bristles import step_coupled_bristles
from gyrostat.wheel.coupled_wheels import step_coupled_wheels
from gyrostat.wheel.data_sheet import WheelSheet, read_wheel_sheet, wheel_sheets
from gyrostat.wheel.driver import Driver
from gyrostat.wheel.model_file import WheelModel, read_model, write_model
from gyrostat.wheel.response import WheelStep, advance, speed_response
from gyrostat.wheel.stepping import step_dry_friction
from gyrostat.wheel.tachometer import Delayed, LowPass, PulseTachometer, Tachometer, WheelTachometer
from gyrostat.wheel.wheel import Wheel

__all__ = [
    "BearingEquation",
    "Changes",
    "CoupledBearings",
    "Delayed",
    "Driver",
    "LowPass",
    "Motion",
    "PulseTachometer",
    "Tachometer",
    "Wheel",
    "WheelArray",
    "WheelModel",
    "WheelSheet",
    "WheelStep",
    "WheelTachometer",
    "advance",
    "orthogonal_axes",
    "pyramid_axes",
    "read_model",
    "read_wheel_sheet",
    "speed_response",
    "step_bristles",
    "step_coupled_bristles",
    "step_coupled_wheels",
    "step_dry_friction",
    "step_wheel",
    "wheel_sheets",
    "write_model",
]
