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

    found: dict[str, FieldLimits] = {}
    known = PARTS[what].fields
    for name, value, text in _given("--range", "LOWER:UPPER", ranges, what):
        both = value.split(":", 1) if isinstance(value, str) else value
        if len(both) != 2:
            raise InputError(f"--range: found {text!r}, expected FIELD=LOWER:UPPER")
        lower, upper = (in_si(end, known[name], f"--range {name}") for end in both)
        if not lower < upper:
            raise InputError(f"--range {name}: found {value}, expected the lower value first")
        found[name] = FieldLimits(lower, upper)
    for name, value, text in _given("--rate-limit", "VALUE", rates, what):
        try:
            rate = float(value)
        except ValueError:
            raise InputError(
                f"--rate-limit: found {text!r}, expected FIELD=VALUE, a number in the SI unit per s"
            ) from None
        require(f"--rate-limit {name}", rate, positive=True)
        found[name] = found.get(name, FieldLimits())._replace(rate=rate)
    return found


def _given(option: str, form: str, values: Named, what: str) -> Iterator[tuple[str, Any, str]]:
    """Field, value and text of each limit."""
    if isinstance(values, Mapping):
        given = [(name, value, f"{name}={value}") for name, value in values.items()]
    else:
        texts = [values] if isinstance(values, str) else values or ()
        given = [(*text.partition("=")[::2], text) for text in texts]
    known, seen = PARTS[what].fields, set()
    for name, value, text in given:
        if not known:
            raise InputError(f"{option}: found {text!r}, expected none with --what {what}")
        if name not in known or value == "":
            raise InputError(
                f"{option}: found {text!r}, expected FIELD={form} with FIELD one of "
                f"{', '.join(known)}"
            )
        if name in seen:
            raise InputError(f"{option}: found {name} twice, expected it once")
        seen.add(name)
        yield name, value, text
