"""Limits of the measurements that exported code accepts."""

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, in_si
from gyrostat.verbs.part_kinds import PARTS

if TYPE_CHECKING:
    from gyrostat.control import FieldLimits


def measurement_limits(what: str, ranges: Named, rates: Named) -> "dict[str, FieldLimits]":
    """Convert the limits of the inputs of an exported part.

    Args:
        what: Key of `gyrostat.verbs.part_kinds.PARTS`.
        ranges: Field -> (lower, upper), or texts FIELD=LOWER:UPPER.
        rates: Field -> largest rate of change, SI unit per second, or texts FIELD=VALUE.

    Raises:
        InputError: A field is unknown or named twice, a text has another form, a range is empty,
            or a rate is not positive.
    """
    from gyrostat.control import FieldLimits
    from gyrostat.core.validation import require

    limits: dict[str, FieldLimits] = {}
    fields = PARTS[what].fields
    for name, value, text in _entries("--range", "LOWER:UPPER", ranges, what):
        bounds = value.split(":", 1) if isinstance(value, str) else value
        if len(bounds) != 2:
            raise InputError(f"--range: found {text!r}, expected FIELD=LOWER:UPPER")
        lower, upper = (in_si(end, fields[name], f"--range {name}") for end in bounds)
        if not lower < upper:
            raise InputError(f"--range {name}: found {value}, expected the lower value first")
        limits[name] = FieldLimits(lower, upper)
    for name, value, text in _entries("--rate-limit", "VALUE", rates, what):
        try:
            rate = float(value)
        except ValueError:
            raise InputError(
                f"--rate-limit: found {text!r}, expected FIELD=VALUE, a number in the SI unit per s"
            ) from None
        require(f"--rate-limit {name}", rate, positive=True)
        limits[name] = limits.get(name, FieldLimits())._replace(rate=rate)
    return limits


def _entries(option: str, form: str, values: Named, part: str) -> Iterator[tuple[str, Any, str]]:
    """Field, value and text of each limit."""
    if isinstance(values, Mapping):
        entries = [(name, value, f"{name}={value}") for name, value in values.items()]
    else:
        texts = [values] if isinstance(values, str) else values or ()
        entries = [(*text.partition("=")[::2], text) for text in texts]
    fields, names = PARTS[part].fields, set()
    for name, value, text in entries:
        if not fields:
            raise InputError(f"{option}: found {text!r}, expected none with --what {part}")
        if name not in fields or value == "":
            raise InputError(
                f"{option}: found {text!r}, expected FIELD={form} with FIELD one of "
                f"{', '.join(fields)}"
            )
        if name in names:
            raise InputError(f"{option}: found {name} twice, expected it once")
        names.add(name)
        yield name, value, text
