"""A reaction wheel with true dry friction, how it answers a current, and its model file."""

from gyrostat.wheel.model_file import WheelModel, read_model, write_model
from gyrostat.wheel.response import speed_response
from gyrostat.wheel.stepping import WheelStep, advance
from gyrostat.wheel.wheel import Wheel

__all__ = [
    "Wheel",
    "WheelModel",
    "WheelStep",
    "advance",
    "read_model",
    "speed_response",
    "write_model",
]
