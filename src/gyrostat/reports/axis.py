"""Axes of charts: range, ticks, and units with a prefix."""

import math
import re
from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Vector

LARGEST = 1e300
"""Largest value on an axis: differences and ratios with it are finite."""
DECADE = 10.0 / 9.0
"""Length of the linear part of an axis that is logarithmic beyond it, in decades."""
_DAY = 86400
_CLOCK = [*(1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800), *(3600, 7200, 10800, 21600, 43200)]
"""Steps of less than a day between dates, s; `chart.js` has the same."""
LONG = 7
"""Number of letters beside an axis, beyond which a number has an exponent if this is shorter."""
_SCALES = {3: "k", 0: "", -3: "m", -6: "µ", -9: "n", -12: "p"}
"""Power of ten -> SI prefix."""
_WITH_PREFIX = re.compile(r"(?!deg|arcsec|rpm|kg)[A-Za-z]+(?=$|[·/])")
"""Begin of a unit that takes a prefix: not a power, whose prefix would have the power too."""


class Axis(NamedTuple):
    """Range of an axis.

    Attributes:
        low: Smallest value.
        high: Largest value.
        label: Quantity with unit.
        is_log: Whether the axis is logarithmic.
        linear: Size up to which an axis that is logarithmic beyond it is linear; 0 for other axes.
        since: Date of the value 0 of an axis in days, as in ISO 8601, whose ticks are dates.
    """

    low: float
    high: float
    label: str
    is_log: bool = False
    linear: float = 0.0
    since: str = ""

    def named(self, value: float) -> str:
        """Name of a tick; `chart.js` does the same."""
        if not self.since:
            return number(value)
        seconds = np.timedelta64(round(_DAY * value), "s")
        text = str(np.datetime64(self.since, "s") + seconds)
        if text.endswith("T00:00:00"):
            return text[:10]
        return text[5:].replace("T", " ").removesuffix(":00")

    def place(self, values: Vector) -> Vector:
        """Places of values between 0 and 1000."""
        low, high = self._scaled(np.array([self.low, self.high]))
        return 1000.0 * (self._scaled(values) - low) / (high - low)

    def _scaled(self, values: Vector) -> Vector:
        """Values of which the axis shows a linear range; `chart.js` computes the same."""
        if self.is_log:
            # what is not above zero has no place on a logarithmic axis; it is far below it
            return np.log10(np.maximum(values, 1e-300))
        if self.linear:
            size = np.abs(values) / self.linear
            return np.sign(values) * np.where(
                size > 1.0, DECADE + np.log10(np.maximum(size, 1.0)), DECADE * size
            )
        return np.asarray(values)

    def ticks(self, most: int = 7) -> list[float]:
        """Values of the ticks; on a linear axis about `most`."""
        if self.is_log:
            powers = range(math.floor(math.log10(self.low)), math.ceil(math.log10(self.high)) + 1)
            steps = (1.0,) if len(powers) > 3 else (1.0, 2.0, 5.0)
            every = [step * 10.0**power for power in powers for step in steps]
            return [v for v in every if self.low * 0.9999 <= v <= self.high * 1.0001]
        if self.linear:
            decades = math.ceil(math.log10(max(-self.low, self.high, self.linear) / self.linear))
            sizes = [self.linear * 10.0**k for k in range(0, decades + 1, 1 + decades // 4)]
            every = [*(-v for v in reversed(sizes)), 0.0, *sizes]
            return [v for v in every if self.low <= v <= self.high]
        step = round_step((self.high - self.low) / most)
        if self.since and step < 1.0:
            least = _DAY * (self.high - self.low) / most * (1.0 - 1e-9)
            step = next((each for each in _CLOCK if each >= least), _DAY) / _DAY
        first, last = math.ceil(self.low / step - 1e-9), math.floor(self.high / step + 1e-9)
        return [k * step for k in range(first, last + 1)]


def round_step(step: float) -> float:
    """The smallest of 1, 2, 5, 10 times a power of ten that is not below a step."""
    power = 10.0 ** math.floor(math.log10(step))
    return next(k * power for k in (1.0, 2.0, 5.0, 10.0) if k * power >= step * (1.0 - 1e-9))


def axis_of(values: Vector, label: str, *, is_log: bool = False, margin: float = 0.04) -> Axis:
    """Axis that has all finite values, with a margin."""
    finite = values[np.isfinite(values) & ((values > 0.0) | (not is_log))]
    finite = np.clip(finite, -LARGEST, LARGEST)
    empty = (1.0, 10.0) if is_log else (0.0, 1.0)
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else empty
    if is_log:
        low, high = max(low, 1.0 / LARGEST), max(high, 1.0 / LARGEST)
        # a span of 2.6 has one of the ticks 1, 2, 5 at least
        factor = max((high / low) ** margin, 1.05, math.sqrt(2.6 * low / high))
        return Axis(low / factor, high * factor, label, is_log=True)
    room = margin * (high - low) or 0.05 * abs(high) or 1.0
    return Axis(low - room, high + room, label)


def scaled_unit(largest: float, unit: str, least: int = -3) -> tuple[float, str]:
    """Factor and unit with an SI prefix, for values up to a size.

    Args:
        largest: Largest absolute value.
        unit: Its unit.
        least: Smallest power of ten, a multiple of 3, that has no prefix.
    """
    if not _WITH_PREFIX.match(unit) or not 0.0 < largest < math.inf:
        return 1.0, unit
    power = 3 * math.floor(math.log10(largest) / 3.0)
    if least <= power <= 3 or power not in _SCALES:
        return 1.0, unit
    return 10.0**-power, _SCALES[power] + unit


def number(value: float) -> str:
    """Number of a tick; `chart.js` does the same."""
    text = f"{value:.6g}"
    if len(text.lstrip("-")) > LONG:
        digits, power = f"{value:.5e}".split("e")
        exponential = f"{digits.rstrip('0').rstrip('.')}e{int(power)}"
        text = min(text, exponential, key=len)
    return text.replace("e-0", "e-").replace("e+0", "e").replace("e+", "e").replace("-", "−")
