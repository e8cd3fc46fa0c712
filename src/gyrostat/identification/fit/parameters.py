"""Validation of parameter names and values given by the user."""

from gyrostat.core.errors import InputError
from gyrostat.core.units import si_unit
from gyrostat.core.validation import magnitude
from gyrostat.identification.fit.prediction import wheel_dimensions
from gyrostat.identification.read.slopes import SLOPES
from gyrostat.wheel.friction import Friction


def parameter_dimension(model: type[Friction], name: str, where: str) -> str:
    """Dimension of a parameter named by the user, before there is a prediction.

    Args:
        model: Friction model.
        name: Name of the parameter.
        where: Option that names it, for the message.

    Raises:
        InputError: No parameter has this name.
    """
    dimensions = {**wheel_dimensions(model), "current_bias": "current", "initial_speed": "speed"}
    dimensions |= {slope: f"{dimension}_per_temperature" for dimension, slope in SLOPES.items()}
    stem = "initial_speed" if name.startswith("initial_speed_") else name
    if stem not in dimensions:
        raise InputError(
            f"{where}: found parameter {name!r}, expected one of {', '.join(dimensions)}"
        )
    return dimensions[stem]


def check_parameter(model: type[Friction], name: str, value: float, where: str) -> None:
    """Validate a value given by the user.

    Args:
        model: Friction model.
        name: Name of the parameter.
        value: Value, SI.
        where: Option that gives the value, for the message.

    Raises:
        InputError: The value is not of a physical magnitude or has the wrong sign.
    """
    dimension = parameter_dimension(model, name, where)
    unit = si_unit(dimension)
    magnitude(where, value, unit)
    of_friction = name in model.dimensions()
    if name in ("inertia", "motor_constant") or (of_friction and dimension == "speed"):
        if value <= 0.0:
            raise InputError(f"{where}: found {value:g}, expected more than 0 {unit}")
    elif of_friction and value < 0.0 and name not in model.signed():
        raise InputError(f"{where}: found {value:g}, expected 0 {unit} or more")
