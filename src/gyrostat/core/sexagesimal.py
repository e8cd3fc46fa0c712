"""Angles in hours or degrees, minutes and seconds."""

import math
import re

from gyrostat.core.errors import InputError

_FORM = re.compile(
    r"""\s*([+-]?)(\d{1,3})\s*([hd°])\s*(\d{1,2})\s*[m'′]\s*(?:(\d{1,2}(?:\.\d*)?)\s*(?:s|"|″|''))?\s*""",
    re.ASCII,
)


def sexagesimal(text: str, where: str) -> float | None:
    """Angle of a text such as '18h36m56.3s' or '-8°12'05"', rad; None for another form.

    Args:
        text: Text.
        where: Place for error messages.

    Raises:
        InputError: Minutes or seconds are not below 60, or the angle exceeds a turn.
    """
    match = _FORM.fullmatch(text)
    if match is None:
        return None
    sign, whole, unit, minutes, seconds = match.groups()
    most = 24.0 if unit == "h" else 360.0
    value = float(whole) + (float(minutes) + float(seconds or 0.0) / 60.0) / 60.0
    if float(minutes) >= 60.0 or float(seconds or 0.0) >= 60.0 or value > most:
        raise InputError(
            f"{where}: found {text.strip()!r}, expected at most {most:g} {unit}, and minutes and "
            "seconds below 60"
        )
    return math.radians(value * (15.0 if unit == "h" else 1.0)) * (-1.0 if sign == "-" else 1.0)
