"""Dimensions, coordinates and attributes of histories."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.simulation.loop import Status

if TYPE_CHECKING:
    import xarray as xr

COMPONENTS = {"quaternion": ("w", "x", "y", "z"), "axis": ("x", "y", "z")}
"""Dimension -> its coordinates."""
OWN_NAMES = (*COMPONENTS, "wheel", "modal", "run", "time", "status", "valid_until", "error")
"""Names that histories have in addition to the signals."""
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


def with_coordinates(dataset: "xr.Dataset") -> "xr.Dataset":
    """Add the coordinates of named dimensions, and `error` if there is a target.

    Args:
        dataset: Histories; wheels and modes are numbered from 0.
    """
    sizes = dataset.sizes
    known: dict[str, Any] = {name: [*parts] for name, parts in COMPONENTS.items() if name in sizes}
    for name in ("wheel", "modal"):
        if name in sizes:
            known[name] = np.arange(sizes[name])
    dataset = dataset.assign_coords(known)
    pair = [dataset[name] for name in ("attitude", "target") if name in dataset]
    if len(pair) == 2 and all("quaternion" in signal.dims for signal in pair):
        first, second = pair
        # q and -q are the same attitude; the chord of an angle a is 2 sin(a / 4)
        chord = np.sqrt(
            np.minimum(
                ((first - second) ** 2).sum("quaternion", skipna=False),
                ((first + second) ** 2).sum("quaternion", skipna=False),
            )
        )
        angle: Any = 4.0 * np.arcsin(np.minimum(0.5 * chord, 1.0))
        dataset["error"] = angle.assign_attrs(units="rad", long_name="pointing error")
    return dataset
