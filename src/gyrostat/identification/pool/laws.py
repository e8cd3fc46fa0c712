"""Laws of a parameter over temperature.

The mean of a parameter at temperature T and date t is

    f(T; shape) (level + trend t) + sum_j c_j phi_j(T)

with a factor f that is 1 at the reference temperature, depends on at most one unknown, the shape,
and is also that of the scatter between records; and columns phi_j with unknown coefficients c_j.
Levels, trends and coefficients are relative to the size of the parameter.
"""

import abc
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.pool.oil import Oil, Vogel

OFFSETS = (100.0, 125.0, 160.0, 210.0)
"""Offsets C of Vogel's equation for an unknown oil, °C."""
POWERS = (0.5, 1.0)
"""Range of the power of the viscosity to which viscous friction is proportional."""
USUAL_FALL, FALL_SPREAD = 0.032, 0.5
"""Prior of the relative decrease of viscous friction at `ROOM`, 1/°C: median, and sigma of its
logarithm. The viscosity of oils falls by 2 to 7 % per °C, to a power of 0.5 to 1."""
ROOM = 20.0
"""Temperature of a room, °C."""


class Law(abc.ABC):
    """A law over temperature.

    Attributes:
        sigmas: Prior standard deviations of the coefficients of the columns, (c,).
    """

    sigmas: tuple[float, ...] = ()

    @property
    def bounds(self) -> tuple[float, float] | None:
        """Range of the shape; None if there is none."""
        return None

    @property
    @abc.abstractmethod
    def slope_sigma(self) -> float:
        """Prior standard deviation of the relative slope at the reference temperature, 1/°C."""

    def log_prior(self, shape: Vector) -> Vector:
        """Logarithm of the prior density of the shape, (s,) -> (s,)."""
        return np.zeros(len(shape))

    @abc.abstractmethod
    def log_factor(self, shape: Vector, temperature: Vector) -> Matrix:
        """Logarithm of the factor, (s,) and (n,) -> (s, n)."""

    def columns(self, temperature: Vector) -> Matrix:
        """Columns, (n,) -> (n, c)."""
        return np.zeros((len(temperature), len(self.sigmas)))


@dataclass(frozen=True)
class Polynomial(Law):
    """Polynomial in T - reference; without coefficients, there is no dependence on temperature.

    Attributes:
        reference: Reference temperature, °C.
        sigmas: Prior standard deviations of the coefficients, 1/°C, 1/°C², ...
    """

    reference: float
    sigmas: tuple[float, ...]

    @property
    def slope_sigma(self) -> float:
        """See `Law.slope_sigma`."""
        return self.sigmas[0] if self.sigmas else 0.0

    def log_factor(self, shape: Vector, temperature: Vector) -> Matrix:
        """See `Law.log_factor`."""
        return np.zeros((len(shape), len(temperature)))

    def columns(self, temperature: Vector) -> Matrix:
        """See `Law.columns`."""
        powers = np.arange(1, len(self.sigmas) + 1)
        return (temperature[:, None] - self.reference) ** powers


@dataclass(frozen=True)
class UnknownOil(Law):
    """Power of the viscosity of an unknown oil by Vogel's equation.

    The shape is the logarithm of the relative decrease at the reference temperature, 1/°C.
    """

    reference: float
    offset: float

    @property
    def bounds(self) -> tuple[float, float]:
        """See `Law.bounds`."""
        middle, reach = float(np.log(USUAL_FALL)), 5.0 * FALL_SPREAD
        return middle - reach, middle + reach

    @property
    def slope_sigma(self) -> float:
        """See `Law.slope_sigma`."""
        return (
            USUAL_FALL * FALL_SPREAD * ((ROOM + self.offset) / (self.reference + self.offset)) ** 2
        )

    def log_prior(self, shape: Vector) -> Vector:
        """See `Law.log_prior`."""
        at_room = shape + 2.0 * np.log((self.reference + self.offset) / (ROOM + self.offset))
        score = (at_room - np.log(USUAL_FALL)) / FALL_SPREAD
        return -0.5 * score**2

    def log_factor(self, shape: Vector, temperature: Vector) -> Matrix:
        """See `Law.log_factor`."""
        unit = Vogel((self.reference + self.offset) ** 2, self.offset)
        return np.exp(shape)[:, None] * unit.log_ratio(temperature, self.reference)


@dataclass(frozen=True)
class KnownOil(Law):
    """Power of the viscosity of a known oil. The shape is the power."""

    reference: float
    oil: Oil

    @property
    def bounds(self) -> tuple[float, float]:
        """See `Law.bounds`."""
        return POWERS

    @property
    def slope_sigma(self) -> float:
        """See `Law.slope_sigma`."""
        fall = self.oil.log_ratio(np.array([self.reference - 0.5]), self.reference + 0.5)
        return float(abs(fall[0]) * (POWERS[1] - POWERS[0]) / np.sqrt(12.0))

    def log_factor(self, shape: Vector, temperature: Vector) -> Matrix:
        """See `Law.log_factor`."""
        return shape[:, None] * self.oil.log_ratio(temperature, self.reference)


def viscous_laws(reference: float, oil: Oil | None) -> Sequence[Law]:
    """Equally likely laws of viscous friction."""
    if oil is not None:
        return (KnownOil(reference, oil),)
    return tuple(UnknownOil(reference, offset) for offset in OFFSETS)
