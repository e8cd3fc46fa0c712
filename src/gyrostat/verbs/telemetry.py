"""Telemetry at the failure of wheels, from options or from one file.

attitude = [0.9239, 0.0, 0.0, 0.3827]              # quaternion, scalar first
# attitude_euler = ["45 deg", 0, 0]                # instead: 3-1-3 angles
rate = ["1 mrad/s", "-2 mrad/s", 0]                # body axes, rad/s; optional, default zero
wheel_speed = ["180 rpm", "-210 rpm", "520 rpm"]   # rad/s, relative to the body
# wheel_speed = {x = "180 rpm", y = "-210 rpm", z = "520 rpm"}
# wheel_momentum = [0.28, -0.33, 0.82]             # instead: inertia times speed, N·m·s
# scalar_last = true                               # the quaternion is scalar last
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError, placed
from gyrostat.verbs.arguments import Quantity, in_si, is_number, numbers, one_attitude, parts_of
from gyrostat.verbs.doubts import angle_doubt, order_doubt
from gyrostat.verbs.required_options import require_given

if TYPE_CHECKING:
    from gyrostat.core.types import Vector
    from gyrostat.failures import Telemetry
    from gyrostat.spacecraft import SpacecraftFile

KEYS = ("attitude", "attitude_euler", "rate", "wheel_speed", "wheel_momentum", "scalar_last")


@dataclass(frozen=True)
class TelemetryOptions:
    """Options that give the telemetry; None if one is not given.

    Attributes:
        attitude: Attitude quaternion, (4,).
        attitude_euler: Attitude as 3-1-3 angles, (3,), rad.
        rate: Body rate in body axes, (3,), rad/s.
        wheels: Momentum of every wheel, N·m·s, or its speed with a unit.
        telemetry: Path of a file with what the other options do not give.
        scalar_last: Whether quaternions have their scalar part last, also that of a file which does
            not say.
    """

    attitude: str | Iterable[float] | None
    attitude_euler: str | Iterable[Quantity] | None
    rate: str | Iterable[Quantity] | None
    wheels: str | Iterable[Quantity] | None
    telemetry: "str | Path | None"
    scalar_last: bool

    @property
    def is_given(self) -> bool:
        """Whether any telemetry is given."""
        options = (self.attitude, self.attitude_euler, self.rate, self.wheels, self.telemetry)
        return any(value is not None for value in options)

    def read(self, file: "SpacecraftFile") -> "tuple[Telemetry, list[str]]":
        """Read and validate the telemetry.

        Args:
            file: Spacecraft.

        Returns:
            The telemetry, and remarks on inputs that may be meant otherwise.

        Raises:
            InputError: A value is missing, given twice or cannot be used.
        """
        import numpy as np

        from gyrostat.failures import Telemetry

        values: dict[str, Any] = {}
        doubts = order_doubt("--attitude", self.attitude, scalar_last=self.scalar_last)
        doubts += angle_doubt("--attitude-euler", self.attitude_euler)
        if self.attitude is not None or self.attitude_euler is not None:
            options = {"--attitude": self.attitude, "--attitude-euler": self.attitude_euler}
            values["attitude"] = one_attitude(
                "attitude at the failure", options, scalar_last=self.scalar_last
            )
        if self.rate is not None:
            values["rate"] = numbers(self.rate, 3, "speed", "--rate")
        if self.wheels is not None:
            values["wheels"] = speeds_of(self.wheels, file)
        where = "telemetry"
        if self.telemetry is not None:
            path = where = Path(self.telemetry)
            file_values, further = _read_file(path, file, scalar_last=self.scalar_last)
            doubts += further
            for name in values.keys() & file_values.keys():
                raise InputError(
                    f"--{name}: found it beside --telemetry {path}, which has it too; expected one"
                )
            values |= file_values
        missing = [name for name in ("attitude", "wheels") if name not in values]
        require_given(str(where), [_MISSING[name] for name in missing])
        attitude: Any = values["attitude"]
        rate = values.get("rate", np.zeros(3))
        with placed(str(where)):
            state = Telemetry.of(file.spacecraft, attitude, rate, values["wheels"])
        return state, doubts


_MISSING = {
    "attitude": "key attitude or attitude_euler, or --attitude or --attitude-euler",
    "wheels": "key wheel_speed or wheel_momentum, or --wheels",
}


def speeds_of(values: str | Iterable[Quantity], file: "SpacecraftFile") -> "Vector":
    """Wheel speeds relative to the body, rad/s, from momenta or from quantities with their units.

    Raises:
        InputError: Their number is not that of the wheels, a value is neither a momentum nor a
            speed, or only some of them have a unit.
    """
    import numpy as np

    count = len(file.wheel_names)
    parts = parts_of(values)
    if len(parts) != count:
        names = ", ".join(file.wheel_names)
        raise InputError(f"--wheels: found {values!r}, expected {count} values, for {names}")
    has_units = [not is_number(part) for part in parts]
    unitless = [p for p, unit in zip(parts, has_units, strict=True) if not unit and float(p) != 0.0]
    if any(has_units) and unitless:
        raise InputError(
            f"--wheels: found {unitless[0]} without and others with a unit, expected a unit for "
            "all, or for none: momenta in N·m·s"
        )
    inertia = np.broadcast_to(np.asarray(file.spacecraft.wheels.inertia), (count,))
    return np.array([_speed(*each) for each in zip(parts, inertia.tolist(), strict=True)])


def _speed(value: Quantity, inertia: float) -> float:
    """Speed, rad/s, from a momentum or a speed with its unit."""
    text = value.strip() if isinstance(value, str) else value
    try:
        return in_si(text, "momentum", "--wheels") / inertia
    except InputError as error:
        try:
            return in_si(text, "speed", "--wheels")
        except InputError:
            raise error from None


def _read_file(
    path: Path, file: "SpacecraftFile", *, scalar_last: bool
) -> tuple[dict[str, Any], list[str]]:
    """Values of a telemetry file, as far as it has them: attitude, rate, wheels (speeds, rad/s).

    Args:
        path: The file.
        file: Spacecraft.
        scalar_last: Order of the quaternion if the file has no key for it.

    Returns:
        The values, and remarks on those that may be meant otherwise.

    Raises:
        InputError: The file cannot be read, or a key is unknown, given twice or cannot be used.
    """
    import numpy as np

    from gyrostat.core.toml_file import described, read_toml, refuse_unknown

    table = read_toml(path, "a telemetry file")
    refuse_unknown(path, "", table, KEYS)
    for first, second in (("attitude", "attitude_euler"), ("wheel_speed", "wheel_momentum")):
        if first in table and second in table:
            raise InputError(f"{path}: found the keys {first} and {second}, expected one of them")
    order = table.get("scalar_last", scalar_last)
    if not isinstance(order, bool):
        raise InputError(f"{path}: key scalar_last: found {described(order)}, expected true, false")
    values: dict[str, Any] = {}
    doubts: list[str] = []
    for key in ("attitude", "attitude_euler"):
        if key in table:
            size, dimension = (4, None) if key == "attitude" else (3, "angle")
            parts = _list(path, key, table[key], [f"[{k}]" for k in range(size)], dimension)
            values["attitude"] = one_attitude(key, {key: parts}, scalar_last=order)
            where = f"{path}: key {key}"
            doubts += (
                order_doubt(where, parts, scalar_last=order)
                if key == "attitude"
                else angle_doubt(where, table[key])
            )
    if "rate" in table:
        parts = _list(path, "rate", table["rate"], [f"[{k}]" for k in range(3)], "speed")
        values["rate"] = np.array(parts)
    inertia = np.broadcast_to(np.asarray(file.spacecraft.wheels.inertia), (len(file.wheel_names),))
    for key, dimension, factor in (
        ("wheel_speed", "speed", 1.0),
        ("wheel_momentum", "momentum", 1.0 / inertia),
    ):
        if key in table:
            entries = _by_wheel(path, key, table[key], file)
            parts = _list(path, key, entries, [f"[{name}]" for name in file.wheel_names], dimension)
            values["wheels"] = factor * np.array(parts)
    return values, doubts


def _by_wheel(path: Path, key: str, value: object, file: "SpacecraftFile") -> object:
    """Values in the order of the wheels, from a list or from a table by name."""
    if not isinstance(value, dict):
        return value
    for name in value:
        file.wheel_number(name, f"{path}: key {key}")
    missing = [f"{key}.{name}" for name in file.wheel_names if name not in value]
    require_given(str(path), missing)
    return [value[name] for name in file.wheel_names]


def _list(
    path: Path, key: str, value: object, ends: list[str], dimension: str | None
) -> list[float]:
    """Numbers of a list of known length, SI."""
    from gyrostat.core.toml_file import described, number, quantity

    if not isinstance(value, list) or len(value) != len(ends):
        raise InputError(
            f"{path}: key {key}: found {described(value)}, expected {len(ends)} values"
        )
    return [
        number(path, f"{key}{end}", entry, positive=False)
        if dimension is None
        else quantity(path, f"{key}{end}", entry, dimension, positive=False)
        for end, entry in zip(ends, value, strict=True)
    ]
