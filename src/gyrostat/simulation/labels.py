"""Dimensions, coordinates and attributes of histories."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from gyrostat.core.checked import declared_units
from gyrostat.core.jax64 import jax
from gyrostat.simulation.labelled import RUN, Labelled, Signal
from gyrostat.simulation.loop import Histories, Status

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


def _arrays(signals: Any) -> Iterator[tuple[str, Any]]:
    """Name and values of each signal; of states of actuators, "actuator_NAME" and their fields."""
    for name, values in signals._asdict().items():
        if isinstance(values, Mapping):
            for path, leaf in jax.tree_util.tree_leaves_with_path(dict(values)):
                suffix = jax.tree_util.keystr(path, simple=True, separator="_")
                yield f"{name.removesuffix('s')}_{suffix}", leaf
        elif values is not None:
            yield name, values


def with_coordinates(variables: dict[str, Signal], coordinates: dict[str, Signal]) -> Labelled:
    """Add the coordinates of named dimensions, and `error` if there is a target.

    Args:
        variables: Signals by name.
        coordinates: Coordinates by name; wheels and modes are numbered from 0.
    """
    pairs = (zip(s.dimensions, np.shape(s.values), strict=True) for s in variables.values())
    sizes = dict(pair for each in pairs for pair in each)
    axes = {
        name: Signal((name,), np.array(parts))
        for name, parts in COMPONENTS.items()
        if name in sizes
    }
    for name in ("wheel", "modal"):
        if name in sizes:
            axes[name] = Signal((name,), np.arange(sizes[name]))
    attitudes = [variables[name] for name in ("attitude", "target") if name in variables]
    if len(attitudes) == 2 and all("quaternion" in signal.dimensions for signal in attitudes):
        first, second = (signal.values for signal in attitudes)
        # q and -q are the same attitude; the chord of an angle a is 2 sin(a / 4)
        squares = (np.sum((first - candidate) ** 2, axis=-1) for candidate in (second, -second))
        angle = 4.0 * np.arcsin(np.minimum(0.5 * np.sqrt(np.minimum(*squares)), 1.0))
        variables = {**variables, "error": Signal((RUN, "time"), angle, ERROR)}
    return Labelled(variables, {**coordinates, **axes})


def labelled(histories: Histories, period: float) -> Labelled:
    """Label the axes of histories, and give them units; see `simulate`.

    Args:
        histories: Signals, each with axes (run, time).
        period: Control period, s.
    """
    count = histories.status.shape[1]
    fine = histories.status == Status.COMPLETE
    variables: dict[str, Signal] = {}
    every = (histories.state, histories.measurement)
    speeds = [signals.wheel_speed for signals in every if hasattr(signals, "wheel_speed")]
    wheels = speeds[0].shape[-1] if speeds else None
    for prefix, signals in (
        ("", histories.state),
        ("recorded_", histories.record),
        ("measured_", histories.measurement),
        ("commanded_", histories.command),
    ):
        units = declared_units(type(signals))
        for name, values in _arrays(signals):
            label_prefix = prefix if name in variables or name in OWN_NAMES else ""
            label = label_prefix + name
            extra = dimensions(name, label, values.shape[2:], wheels)
            mask = fine.reshape(*fine.shape, *(1,) * len(extra))
            values = values & mask if values.dtype == bool else np.where(mask, values, np.nan)
            about = attributes(name, label_prefix, units)
            variables[label] = Signal((RUN, "time", *extra), values, about)
    last = np.where(fine.all(axis=1), count, np.argmin(fine, axis=1)) - 1
    status = histories.status.max(axis=1).astype(np.int8)
    variables["status"] = Signal((RUN,), status, status_attributes())
    # a run that has diverged at the start has no valid sample
    until = np.where(last >= 0, last * period, np.nan)
    lasts = {"units": "s", "long_name": "time of the last valid sample"}
    variables["valid_until"] = Signal((RUN,), until, lasts)
    time = Signal(("time",), np.arange(count) * period, {"units": "s", "long_name": "time"})
    coordinates = {"time": time, RUN: Signal((RUN,), np.arange(len(fine)))}
    return with_coordinates(variables, coordinates)
