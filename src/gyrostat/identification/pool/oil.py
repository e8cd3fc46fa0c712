"""Viscosity of an oil over temperature.

Vogel's equation, eta = A exp(B / (T + C)) with T in °C, and Walther's,
lg lg (nu + 0.7) = a - b lg T with T in K and the kinematic viscosity nu in mm²/s (ASTM D341). The
dynamic viscosity is nu times the density, which falls by `EXPANSION` per °C. Only ratios of
viscosities are used.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import ascii_number

KELVIN = 273.15
EXPANSION = 7e-4
"""Relative decrease of the density of oils, 1/°C."""


@dataclass(frozen=True)
class Vogel:
    """Vogel's equation.

    Attributes:
        slope: B, °C.
        offset: C, °C.
    """

    slope: float
    offset: float

    def log_ratio(self, temperature: Vector, reference: float) -> Vector:
        """Logarithm of the dynamic viscosity over that at the reference; °C."""
        return self.slope * (1.0 / (temperature + self.offset) - 1.0 / (reference + self.offset))


@dataclass(frozen=True)
class Walther:
    """Walther's equation, from the kinematic viscosities at two temperatures.

    Attributes:
        temperatures: Two temperatures, °C.
        viscosities: Kinematic viscosities there, mm²/s.
    """

    temperatures: tuple[float, float]
    viscosities: tuple[float, float]

    def log_ratio(self, temperature: Vector, reference: float) -> Vector:
        """See `Vogel.log_ratio`."""
        places = np.log10(np.array(self.temperatures) + KELVIN)
        heights = np.log10(np.log10(np.array(self.viscosities) + 0.7))
        fall = (heights[1] - heights[0]) / (places[1] - places[0])

        def log_viscosity(value: Vector | float) -> Vector:
            height = heights[0] + fall * (np.log10(np.asarray(value) + KELVIN) - places[0])
            density = np.log1p(-EXPANSION * (np.asarray(value) - reference))
            return np.log(10.0 ** (10.0**height) - 0.7) + density

        return log_viscosity(temperature) - log_viscosity(reference)


Oil = Vogel | Walther


def parse_oil(text: str, where: str) -> Oil:
    """Oil from text: "40:108,100:14.6" or "vogel:845,110".

    Args:
        text: Two temperatures, °C, with kinematic viscosities, mm²/s; or B and C of Vogel's
            equation, °C.
        where: Name of the option, for the message.

    Raises:
        InputError: The text is not of these forms, or the viscosity does not fall.
    """
    fault = InputError(
        f"{where}: found {text!r}, expected two temperatures in °C with viscosities in mm²/s that "
        "fall, such as 40:108,100:14.6, or B and C of Vogel's equation in °C, such as "
        "vogel:845,110"
    )
    kind, _, rest = text.partition(":")
    is_vogel = kind.strip().lower() == "vogel"
    try:
        pairs = [part.split(":") for part in (rest if is_vogel else text).split(",")]
        numbers = [[ascii_number(number.strip()) for number in pair] for pair in pairs]
    except ValueError:
        raise fault from None
    if is_vogel and [len(pair) for pair in numbers] == [1, 1]:
        (slope,), (offset,) = numbers
        if slope > 0.0 and 30.0 < offset < KELVIN:
            return Vogel(slope, offset)
    elif [len(pair) for pair in numbers] == [2, 2]:
        (cold, thick), (warm, thin) = sorted(numbers)
        if -KELVIN < cold < warm and thick > thin > 0.5:
            return Walther((cold, warm), (thick, thin))
    raise fault
