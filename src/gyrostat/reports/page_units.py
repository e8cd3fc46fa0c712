"""Units of pages: one for each quantity, and values as text."""

import math

from gyrostat.core.text import plain
from gyrostat.core.units import RPM
from gyrostat.reports.axis import scaled_unit

_SHOWN = {"rad": (math.degrees(1.0), "deg"), "rad/s": (math.degrees(1.0), "deg/s")}
_SHOWN |= {"N·m": (1e6, "µN·m"), "1": (1.0, "")}
"""SI unit -> factor to the unit in which all pages show a quantity, and this unit."""
BENCH_TORQUE = 1e3, "mN·m"
"""Factor from SI and unit of the friction of a wheel on all pages of records and fits."""
_BENCH = {"N·m": BENCH_TORQUE, "rad/s": (1.0 / RPM, "rpm")}
"""SI unit -> factor and unit in which these pages show a quantity."""
WHOLE = 1e4, 1e7
"""Sizes from and below which a number is shown without an exponent."""


def shown_unit(unit: str) -> tuple[float, str]:
    """Factor from SI and unit in which reports show a value; the unit of a ratio is empty."""
    return _SHOWN.get(unit, (1.0, unit))


def bench_unit(unit: str, largest: float = 1.0) -> tuple[float, str]:
    """Factor from SI and unit in which pages of records and fits show a quantity of a wheel.

    Args:
        unit: SI unit.
        largest: Largest value, for the prefix of a unit that these pages do not fix.
    """
    return _BENCH.get(unit) or scaled_unit(largest, unit, 0)


def labelled(name: str, unit: str) -> str:
    """Name of a quantity with its unit in brackets, if it has one."""
    return f"{name} ({unit})" if unit else name


def told(value: float | None, unit: str, digits: int = 4) -> str:
    """Format a value with a number of significant digits, in the unit of the pages."""
    return told_in(value, *shown_unit(unit), digits)


def told_in(value: float | None, factor: float, unit: str, digits: int = 4) -> str:
    """Format a value with a factor from SI and the unit that this gives."""
    if value is None or not math.isfinite(value):
        return "none"
    shown = factor * value
    whole = WHOLE[0] <= abs(shown) < WHOLE[1] and abs(shown) >= 10.0**digits
    text = f"{shown:.0f}" if whole else plain(shown, digits)
    return f"{text} {unit}".rstrip()


def page_unit(name: str, unit: str) -> tuple[float, str]:
    """Factor from SI and unit in which a page has a metric or dispersed value.

    Args:
        name: Metric or key.
        unit: SI unit.
    """
    if unit == "rad/s" and name.startswith("wheel."):
        return 1.0 / RPM, "rpm"
    return shown_unit(unit)
