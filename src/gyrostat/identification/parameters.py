"""Parameters that a request names: their dimensions, and values that no wheel has."""

from gyrostat.core.errors import InputError
from gyrostat.core.units import SI_UNIT
from gyrostat.core.validation import magnitude
from gyrostat.identification.prediction import wheel_dimensions
from gyrostat.identification.slopes import SLOPES
from gyrostat.wheel.friction import Friction


def parameter_dimension(model: type[Friction], name: str, where: str) -> str:
    """Dimension of a parameter that a request names, before there is a prediction.

    Args:
        model: friction model.
        name: of the parameter.
        where: what names it, for the message.

    Raises:
        InputError: no parameter has this name.
    """
    known = {**wheel_dimensions(model), "current_bias": "current", "initial_speed": "speed"}
    known |= {slope: f"{dimension}_per_temperature" for dimension, slope in SLOPES.items()}
    stem = "initial_speed" if name.startswith("initial_speed_") else name
    if stem not in known:
        raise InputError(f"{where}: found parameter {name!r}, expected one of {', '.join(known)}")
    return known[stem]


def check_parameter(model: type[Friction], name: str, value: float, where: str) -> None:
    """Refuse a value that no wheel has, before anything is computed with it.

    Args:
        model: friction model.
        name: of the parameter.
        value: SI.
        where: what gives it, for the message.

    Raises:
        InputError: it is of no physical magnitude or of the wrong sign.
    """
    dimension = parameter_dimension(model, name, where)
    unit = SI_UNIT[dimension]
    magnitude(where, value, unit)
    of_friction = name in model.dimensions()
    if name in ("inertia", "motor_constant") or (of_friction and dimension == "speed"):
        if value <= 0.0:
            raise InputError(f"{where}: found {value:g}, expected more than 0 {unit}")
    elif of_friction and value < 0.0:
        raise InputError(f"{where}: found {value:g}, expected 0 {unit} or more")
