"""Quantities of a wheel's data sheet with their acceptance limits.

Each table of a sheet may have `minimum` and `maximum`, or a `tolerance` about its `value` (a
quantity, or a share such as "3 %"). A capacity or a loss with only a `value` is limited by it: a
momentum capacity must reach it, a loss torque must not exceed it.

[motor_constant]
value = "22.8 mN·m/A"
tolerance = "3 %"
source = "specification 3.1"

[[loss_torque]]        # several tables, each at its own speed
speed = "4000 rpm"
maximum = "2.5 mN·m"
source = "specification 3.2"
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.toml_file import quantity, refuse_unknown
from gyrostat.core.units import SI_UNIT, Unit, ascii_number, unit_of


@dataclass(frozen=True)
class Quantity(Described):
    """Kind of quantity of a data sheet.

    Attributes:
        title: Name in tables.
        dimension: Key of `gyrostat.core.units.SI_UNIT`.
        bound: Limit that a value without limits states: "minimum", "maximum" or none.
        conditions: Conditions that its table may state: speed, current.
        required: Conditions that its table must state.
        test: Test of `gyrostat bench --tests` that measures it, if a record of current and speed
            alone does not show it.
    """

    title: str
    dimension: str
    bound: str = ""
    conditions: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    test: str = ""


_AT_SPEED: dict[str, Any] = {"conditions": ("speed",), "required": ("speed",)}
QUANTITIES = {
    "momentum_limit": Quantity("momentum capacity", "momentum", "minimum"),
    "speed_limit": Quantity("speed reached", "speed", "minimum"),
    "inertia": Quantity("inertia", "inertia"),
    "coulomb": Quantity("Coulomb torque", "torque"),
    "viscous": Quantity("viscous coefficient", "viscous"),
    "torque_limit": Quantity("maximum torque", "torque", "minimum", ("current", "speed")),
    "static": Quantity("breakaway torque", "torque"),
    "stribeck_speed": Quantity("Stribeck speed", "speed"),
    "motor_constant": Quantity("motor constant", "motor_constant"),
    "loss_torque": Quantity("loss torque", "torque", "maximum", **_AT_SPEED),
    "zero_crossing_torque": Quantity("torque step at zero speed", "torque", "maximum"),
    "coast_down_time": Quantity("coast-down time", "time", "minimum", **_AT_SPEED),
    "torque_ripple": Quantity(
        "breakaway torque, scatter over angles", "torque", "maximum", test="breakaway"
    ),
    "crossing_repeatability": Quantity(
        "torque step at zero crossings, scatter", "torque", "maximum", test="zero-crossing"
    ),
    "run_in_change": Quantity(
        "loss torque, change per hour after run-in", "torque", "maximum", test="run-in"
    ),
    "thermal_loss_torque": Quantity(
        "largest loss torque over temperature",
        "torque",
        "maximum",
        test="thermal-vacuum",
        **_AT_SPEED,
    ),
    "torque_noise": Quantity("torque noise, rms", "torque", "maximum", test="torque-noise"),
    "static_imbalance": Quantity("static imbalance", "imbalance", "maximum"),
    "dynamic_imbalance": Quantity("dynamic imbalance", "inertia", "maximum"),
}
"""Key of a table -> kind of quantity."""
_MAY_BE_ZERO = ("coulomb", "viscous", "static", "static_imbalance", "dynamic_imbalance")


@dataclass(frozen=True)
class Limit(Described):
    """Quantity of a data sheet with its acceptance limits.

    Attributes:
        quantity: Key of `QUANTITIES`.
        value: Stated value, SI; None if only limits are stated.
        minimum: Smallest accepted value, SI; minus infinity without one.
        maximum: Largest accepted value, SI; infinity without one.
        conditions: "speed", rad/s, and "current", A, at which the limits apply.
        unit: Unit of the sheet, for tables.
        source: Source of the value and limits.
    """

    quantity: str
    value: float | None
    minimum: float
    maximum: float
    conditions: Mapping[str, float]
    unit: Unit
    source: str

    @property
    def limited(self) -> bool:
        """Whether there is a limit at all."""
        return self.minimum > -math.inf or self.maximum < math.inf


def read_limit(path: Path, where: str, key: str, entry: object) -> Limit:
    """Read one table of a data sheet.

    Args:
        path: Path of the file, for the error message.
        where: Place in the file, for the error message.
        key: Key of `QUANTITIES`.
        entry: Content of the table.

    Raises:
        InputError: A key is unknown or missing, a value is not possible for a wheel, or limits
            contradict each other.
    """
    kind = QUANTITIES[key]
    if not isinstance(entry, dict):
        raise InputError(f"{path}: key {where}: found {entry!r}, expected a table [{key}]")
    numbers = ("value", "minimum", "maximum", "tolerance")
    refuse_unknown(path, f"{where}.", entry, (*numbers, "source", *kind.conditions))
    source = entry.get("source")
    if not isinstance(source, str) or not source:
        raise InputError(f"{path}: key {where}.source: found {source!r}, expected where it is from")

    def read(name: str, dimension: str, *, positive: bool) -> float:
        found = quantity(path, f"{where}.{name}", entry.get(name), dimension, positive=positive)
        if found < 0.0:
            raise InputError(f"{path}: key {where}.{name}: found {found:g}, expected 0 or more")
        return found

    values = {
        name: read(name, kind.dimension, positive=name == "value" and key not in _MAY_BE_ZERO)
        for name in ("value", "minimum", "maximum")
        if name in entry or (name == "value" and not {"minimum", "maximum"} & set(entry))
    }
    for name in kind.required:
        if name not in entry:
            raise InputError(f"{path}: key {where}.{name}: found none, expected the {name}")
    conditions = {n: read(n, n, positive=True) for n in kind.conditions if n in entry}
    if "tolerance" in entry:
        values |= _about(path, where, entry, values, kind.dimension)
    elif kind.bound and not {"minimum", "maximum"} & set(values):
        values[kind.bound] = values["value"]
    low, high = values.get("minimum", -math.inf), values.get("maximum", math.inf)
    value = values.get("value")
    if not low <= (low if value is None else value) <= high:
        inside = "" if value is None else f", value {value:g}"
        raise InputError(
            f"{path}: key {where}: found minimum {low:g}, maximum {high:g}{inside} "
            f"{SI_UNIT[kind.dimension]}, expected them in order"
        )
    texts = [entry[n] for n in ("value", "minimum", "maximum") if isinstance(entry.get(n), str)]
    text = texts[0] if texts else "0"
    unit = unit_of(text, kind.dimension, f"{path}: key {where}")
    return Limit(key, value, low, high, conditions, unit, source)


def _about(
    path: Path, where: str, entry: Mapping[str, Any], values: Mapping[str, float], dimension: str
) -> dict[str, float]:
    """Limits by a tolerance about the stated value."""
    key, tolerance = f"{where}.tolerance", entry["tolerance"]
    if set(values) != {"value"}:
        raise InputError(
            f"{path}: key {key}: found {tolerance!r} beside {', '.join(values)}, expected it "
            "beside a value alone"
        )
    value = values["value"]
    share = isinstance(tolerance, str) and tolerance.rstrip().endswith("%")
    if share:
        try:
            width = value * ascii_number(tolerance.rstrip().removesuffix("%")) / 100.0
        except ValueError:
            width = math.nan
        if width >= value > 0.0:
            raise InputError(f"{path}: key {key}: found {tolerance!r}, expected less than 100 %")
    else:
        width = quantity(path, key, tolerance, dimension, positive=False)
    if not 0.0 <= width < math.inf:
        raise InputError(f"{path}: key {key}: found {tolerance!r}, expected one such as '3 %'")
    return {"minimum": value - width, "maximum": value + width}
