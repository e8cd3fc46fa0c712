"""A reaction wheel with true dry friction, how it answers a current, and its model file."""

from gyrostat.core.show import show_values
from gyrostat.wheel.array import WheelArray
from gyrostat.wheel.axes import orthogonal_axes, pyramid_axes
from gyrostat.wheel.bristles import bend, carry
from gyrostat.wheel.contact import Contact, Motion
from gyrostat.wheel.contacts import Changes, Contacts
from gyrostat.wheel.coupled_wheels import slide_together
from gyrostat.wheel.data_sheet import WheelSheet, read_wheel_sheet, wheel_sheets
from gyrostat.wheel.driver import Driver
from gyrostat.wheel.model_file import WheelModel, read_model, write_model
from gyrostat.wheel.response import WheelStep, advance, speed_response
from gyrostat.wheel.stepping import slide
from gyrostat.wheel.tachometer import Delayed, LowPass, PulseTachometer, Tachometer, WheelTachometer
from gyrostat.wheel.wheel import Wheel

__all__ = [
    "Changes",
    "Contact",
    "Contacts",
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
    "bend",
    "carry",
    "orthogonal_axes",
    "pyramid_axes",
    "read_model",
    "read_wheel_sheet",
    "slide",
    "slide_together",
    "speed_response",
    "wheel_sheets",
    "write_model",
]

show_values([*globals().values()])
