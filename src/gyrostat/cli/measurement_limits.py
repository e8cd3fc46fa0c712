"""Limits of measurements from the command line."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from gyrostat.control import FieldLimits

TABLE = {"attitude": "angle", "rate": "speed", "speed": "speed"}
FIELDS = {
    "compensated-wheel": TABLE,
    "compensator": TABLE,
    "controller": {"attitude": "angle", "rate": "speed"},
    "estimator": {"current": "current", "measured": "speed"},
    "wheel": {},
}
"""What is exported -> its measured fields and their dimensions."""


def measurement_limits(
    what: str, ranges: Sequence[str], rates: Sequence[str]
) -> "dict[str, FieldLimits]":
    """Limits of the inputs of what is exported.

    Args:
        what: Key of `FIELDS`.
        ranges: Texts FIELD=LOWER:UPPER.
        rates: Texts FIELD=VALUE, SI unit per second.

    Raises:
        InputError: a field is another one or named twice, a text has another form, a range is
            empty, a rate is not above 0.
    """
    from gyrostat.control import FieldLimits
    from gyrostat.core.units import parse_quantity
    from gyrostat.core.validation import require

    found: dict[str, FieldLimits] = {}
    known = FIELDS[what]
    given = set()
    for option, texts in (("--range", ranges), ("--rate-limit", rates)):
        for text in texts:
            name, equals, value = text.partition("=")
            if not known:
                raise InputError(f"{option}: found {text!r}, expected none with --what {what}")
            if not equals or name not in known:
                form = "LOWER:UPPER" if option == "--range" else "VALUE"
                raise InputError(
                    f"{option}: found {text!r}, expected FIELD={form} with FIELD one of "
                    f"{', '.join(known)}"
                )
            if (option, name) in given:
                raise InputError(f"{option}: found {name} twice, expected it once")
            given.add((option, name))
            limits = found.get(name, FieldLimits())
            if option == "--rate-limit":
                rate = _number(value, text)
                require(f"--rate-limit {name}", rate, positive=True)
                found[name] = limits._replace(rate=rate)
                continue
            lower, colon, upper = value.partition(":")
            if not colon:
                raise InputError(f"{option}: found {text!r}, expected FIELD=LOWER:UPPER")
            ends = [parse_quantity(end, known[name], f"--range {name}") for end in (lower, upper)]
            if not ends[0] < ends[1]:
                raise InputError(f"--range {name}: found {value}, expected the lower value first")
            found[name] = limits._replace(lower=ends[0], upper=ends[1])
    return found


def _number(value: str, text: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise InputError(
            f"--rate-limit: found {text!r}, expected FIELD=VALUE, a number in the SI unit per s"
        ) from None
