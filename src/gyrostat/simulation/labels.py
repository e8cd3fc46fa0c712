"""Dimensions, coordinates and attributes of histories."""

from typing import Any

import numpy as np

from gyrostat.simulation.labelled import RUN, Labelled, Signal
from gyrostat.simulation.loop import Status

COMPONENTS = {"quaternion": ("w", "x", "y", "z"), "axis": ("x", "y", "z")}
"""Dimension -> its coordinates."""
OWN_NAMES = (*COMPONENTS, "wheel", "modal", "run", "time", "status", "valid_until", "error")
"""Names that histories have in addition to the signals."""
ERROR = {"units": "rad", "long_name": "pointing error"}
"""Attributes of the signal `error`."""
_QUATERNIONS = ("attitude", "target", "estimated_attitude")
_VECTORS = (
    *("momentum", "rate", "jitter", "external_torque"),
    *("estimated_rate", "estimated_bias", "attitude_sigma", "innovation"),
)
_PER_WHEEL = (
    *("wheel_speed", "wheel_momentum", "wheel_angle", "wheel_measured", "motor_current"),
    *("torque", "torque_demand", "speed", "set_point", "integral", "saturated", "works"),
    "deflection",
)
_PER_MODE = ("modal_coordinate", "modal_momentum", "modal_rate")
_LONG_NAMES = {
    "attitude": "attitude of the body relative to inertial space",
    "momentum": "total angular momentum, inertial axes",
    "rate": "body rate, body axes",
    "torque": "motor torque",
    "target": "target attitude",
    "modal_momentum": "generalised momentum of the modes",
    "works": "wheel considered working",
    "saturated": "at the torque limit",
    "deflection": "deflection of the bristles",
}


def dimensions(field: str, label: str, shape: tuple[int, ...], wheels: int | None) -> list[str]:
    """Names of the dimensions of a signal, in addition to run and time.

    Args:
        field: Name of the signal in its named tuple.
        label: Name of the signal in the histories, from which other dimensions are named.
        shape: Shape of one sample.
        wheels: Number of wheels; None if it is not known.
    """
    if len(shape) == 1:
        for names, count, dimension in (
            (_QUATERNIONS, 4, "quaternion"),
            (_VECTORS, 3, "axis"),
            (_PER_WHEEL, wheels, "wheel"),
            (_PER_MODE, shape[0], "modal"),
        ):
            if field in names and shape[0] == count:
                return [dimension]
    return [f"{label}_{k}" for k in range(1, len(shape) + 1)]


def attributes(field: str, prefix: str, units: dict[str, str]) -> dict[str, str]:
    """Long name of a signal and, if declared, its unit.

    Args:
        field: Name of the signal in its named tuple.
        prefix: Prefix of the name in the histories, such as "measured_"; may be empty.
        units: Declared units: name -> unit.
    """
    name = prefix.replace("_", " ") + _LONG_NAMES.get(field, field.replace("_", " "))
    return {"long_name": name, **({"units": units[field]} if field in units else {})}


def status_attributes() -> dict[str, Any]:
    """Attributes of the variable `status`."""
    return {
        "long_name": "how the run ended",
        "flag_values": [int(s) for s in Status],
        "flag_meanings": " ".join(s.name.lower() for s in Status),
    }


def with_coordinates(variables: dict[str, Signal], coordinates: dict[str, Signal]) -> Labelled:
    """Add the coordinates of named dimensions, and `error` if there is a target.

    Args:
        variables: Signals by name.
        coordinates: Coordinates by name; wheels and modes are numbered from 0.
    """
    pairs = (zip(s.dimensions, np.shape(s.values), strict=True) for s in variables.values())
    sizes = dict(pair for each in pairs for pair in each)
    known = {
        name: Signal((name,), np.array(parts))
        for name, parts in COMPONENTS.items()
        if name in sizes
    }
    for name in ("wheel", "modal"):
        if name in sizes:
            known[name] = Signal((name,), np.arange(sizes[name]))
    pair = [variables[name] for name in ("attitude", "target") if name in variables]
    if len(pair) == 2 and all("quaternion" in signal.dimensions for signal in pair):
        first, second = (signal.values for signal in pair)
        # q and -q are the same attitude; the chord of an angle a is 2 sin(a / 4)
        squares = (np.sum((first - turned) ** 2, axis=-1) for turned in (second, -second))
        angle = 4.0 * np.arcsin(np.minimum(0.5 * np.sqrt(np.minimum(*squares)), 1.0))
        variables = {**variables, "error": Signal((RUN, "time"), angle, ERROR)}
    return Labelled(variables, {**coordinates, **known})
