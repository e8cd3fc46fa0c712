"""Conversion of the verbs' arguments: numbers, text with units, mappings, paths or objects."""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.core.messages import silent as silent
from gyrostat.core.messages import to_stderr as to_stderr

if TYPE_CHECKING:
    from pathlib import Path

    from gyrostat.campaigns.executors import Opener
    from gyrostat.core.types import Vector
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile

Say = Callable[[str], None]
"""Function that receives a message for the user."""
Quantity = float | str
"""Number in SI units, or text with a unit such as "5 rpm"."""
Named = Mapping[str, Any] | str | Iterable[str] | None
"""Values by name: a mapping, or text NAME=VALUE,NAME=VALUE in one or several pieces."""
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def in_si(value: Quantity, dimension: str, where: str) -> float:
    """Convert a quantity to SI.

    Args:
        value: Number in SI units, or text.
        dimension: Key of `gyrostat.core.units.SI_UNIT`.
        where: Name for the message.

    Raises:
        InputError: The value is not a finite number, or its unit is unknown.
    """
    from gyrostat.core.units import parse_quantity

    return parse_quantity(value if isinstance(value, str) else repr(float(value)), dimension, where)


def in_si_or_none(value: Quantity | None, dimension: str, where: str) -> float | None:
    """Convert a quantity to SI; None stays None."""
    return None if value is None else in_si(value, dimension, where)


def opener_of(scheduler: str | None, say: Say) -> "Opener | None":
    """Opener of the workers of a Dask scheduler; None for this machine.

    Args:
        scheduler: Address of the scheduler, or None.
        say: Called with a message about each worker that is refused.

    Raises:
        InputError: Dask is not installed.
    """
    if scheduler is None:
        return None
    from gyrostat.campaigns.cluster import cluster

    return cluster(scheduler, say)


def is_number(value: object) -> bool:
    """Whether a value has no unit."""
    from gyrostat.core.units import ascii_number

    try:
        ascii_number(str(value))
    except ValueError:
        return False
    return True


def parts_of(value: Quantity | Iterable[Quantity]) -> list[Quantity]:
    """Split text at its commas; list numbers."""
    if isinstance(value, str):
        return [*value.split(",")]
    return list(value) if isinstance(value, Iterable) else [value]


def quantities(
    value: Quantity | Iterable[Quantity] | None, dimension: str, where: str
) -> list[float]:
    """Convert one or several quantities to SI: numbers, or text separated by commas.

    Raises:
        InputError: As for `in_si`.
    """
    parts = [] if value is None or not _is_given(value) else parts_of(value)
    return [in_si(p.strip() if isinstance(p, str) else p, dimension, where) for p in parts]


def numbers(
    value: str | Iterable[Quantity], count: int, dimension: str | None, where: str
) -> "Vector":
    """Convert a fixed number of values to SI.

    Args:
        value: Numbers, or text separated by commas.
        count: Number of values.
        dimension: Key of `gyrostat.core.units.SI_UNIT`; None for plain numbers.
        where: Name for the message.

    Returns:
        Values, (count,).

    Raises:
        InputError: The number of values differs from `count`, or a value is not a number.
    """
    import numpy as np

    from gyrostat.core.units import ascii_number

    parts = parts_of(value)
    if len(parts) != count:
        raise InputError(f"{where}: found {value!r}, expected {count} values with commas between")
    if dimension is not None:
        return np.array(quantities(parts, dimension, where))
    try:
        return np.array([ascii_number(p) if isinstance(p, str) else float(p) for p in parts])
    except (ValueError, TypeError):
        raise InputError(f"{where}: found {value!r}, expected {count} numbers") from None


def whole_numbers(value: str | Iterable[int], where: str) -> list[int]:
    """Convert integers: a sequence, or text separated by commas.

    Raises:
        InputError: A part is not an integer.
    """
    if not isinstance(value, str):
        return list(value)
    try:
        return [int(part) for part in value.split(",") if part.strip()]
    except ValueError:
        raise InputError(
            f"{where}: found {value!r}, expected numbers with commas between"
        ) from None


def direction(value: str | Iterable[float], where: str) -> "Vector":
    """Convert a direction to a unit vector (3,): three numbers of any length, or x, -y, ....

    Raises:
        InputError: The value is not a direction.
    """
    import numpy as np

    from gyrostat.failures.query import unit_vector

    if isinstance(value, str):
        name, sign = value.strip().lstrip("+-"), -1.0 if value.strip().startswith("-") else 1.0
        if name in AXES:
            return sign * np.array(AXES[name])
    return unit_vector(numbers(value, 3, None, where), where)


def one_attitude(
    what: str, options: Mapping[str, Any], *, scalar_last: bool = False
) -> "Vector | None":
    """Convert the one attitude given among several options to a quaternion (4,).

    Args:
        what: Meaning of the attitude, for the message.
        options: Option -> its value; a name with "euler" in it means 3-1-3 angles, one with
            "boresight" no attitude.
        scalar_last: Whether a given quaternion has its scalar part last.

    Returns:
        Quaternion, scalar first; None for an option that is not an attitude.

    Raises:
        InputError: None or several are given.
    """
    import numpy as np

    names = [option for option, value in options.items() if value is not None]
    if len(names) != 1:
        found = " and ".join(names) or "none"
        raise InputError(f"{what}: found {found}, expected one of {', '.join(options)}")
    name, value = names[0], options[names[0]]
    if "boresight" in name:
        return None
    if "euler" not in name:
        return np.roll(numbers(value, 4, None, name), 1 if scalar_last else 0)
    from scipy.spatial.transform import Rotation

    angles = numbers(value, 3, "angle", name)
    return Rotation.from_euler("ZXZ", angles).as_quat(scalar_first=True) + np.zeros(4)


def named(values: Named, where: str, *, bare: bool = False) -> dict[str, Any]:
    """Split named values.

    Args:
        values: Mapping, or texts NAME=VALUE.
        where: Option, for the message.
        bare: Whether a NAME without a value is allowed; its value is None.

    Raises:
        InputError: A part has no name or no value, or a name is repeated.
    """
    if values is None or isinstance(values, Mapping):
        return {str(name): value for name, value in (values or {}).items()}
    entries: dict[str, Any] = {}
    for item in [values] if isinstance(values, str) else values:
        for part in item.split(","):
            name, equals, value = (p.strip() for p in part.partition("="))
            if not bare and not part.strip():
                continue
            if not bare and not (name and equals and value):
                raise InputError(f"{where}: found {part.strip()!r}, expected NAME=VALUE")
            if name in entries:
                raise InputError(f"{where}: found {name} twice, expected it once")
            entries[name] = value or None
    return entries


def one_of(value: str, known: Iterable[str], where: str) -> str:
    """Check that a value is one of the allowed ones.

    Raises:
        InputError: The value is not allowed.
    """
    if value not in [*known]:
        raise InputError(f"{where}: found {value!r}, expected one of {', '.join(known)}")
    return value


def _is_given(value: Any) -> bool:
    """Whether an option has a value; the number 0 is a value."""
    if value is None or isinstance(value, bool):
        return bool(value)
    return not hasattr(value, "__len__") or len(value) > 0


def refuse_given(options: Mapping[str, object], where: str, expected: str) -> None:
    """Reject options that would have no effect.

    Args:
        options: Name -> value given by the user, empty if none was given.
        where: Option with which they have no effect.
        expected: Options with which they have an effect.

    Raises:
        InputError: An option was given.
    """
    names = [option for option, value in options.items() if _is_given(value)]
    if names:
        raise InputError(f"{where}: found {', '.join(names)}, expected these with {expected} only")


def folder_name(name: str, runs: int, seed: int) -> str:
    """Default name of a campaign's folder."""
    slug = re.sub(r"\W+", "-", name).strip("-") or "campaign"
    return f"{slug}-{runs}-runs-seed-{seed}"


def check_device(name: str) -> None:
    """Check that JAX may be asked for a device; raises `InputError`."""
    from gyrostat.runs.fingerprint import FLAGS

    one_of(name, FLAGS, "--device")


def spacecraft_file(spacecraft: "SpacecraftFile | Spacecraft | str | Path") -> "SpacecraftFile":
    """Read spacecraft.toml; the wheels of a spacecraft object are named by their numbers."""
    from gyrostat.spacecraft import Spacecraft, SpacecraftFile, read_spacecraft

    if isinstance(spacecraft, Spacecraft):
        spacecraft.check()
        names = tuple(str(k) for k in range(spacecraft.wheels.count))
        return SpacecraftFile("", names, spacecraft, ({},) * len(names))
    return spacecraft if isinstance(spacecraft, SpacecraftFile) else read_spacecraft(spacecraft)


FIGURES = ("pdf", "svg", "png")
"""Kinds of the files of figures for papers."""


def figure_names(kind: str | None, *stems: str) -> list[str]:
    """Names of the files of figures; none without a kind.

    Raises:
        InputError: There is no such kind.
    """
    if kind is None:
        return []
    if kind not in FIGURES:
        raise InputError(f"--figures: found {kind!r}, expected one of {', '.join(FIGURES)}")
    return [f"{stem}.{kind}" for stem in stems]
