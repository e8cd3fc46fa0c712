"""Table of units: dimension -> units with their factors and spellings."""

import itertools
import math
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

RPM = 2.0 * math.pi / 60.0
"""One revolution per minute, rad/s."""
_DEGREE = math.pi / 180.0


@dataclass(frozen=True)
class Unit:
    """A unit of one dimension: value in SI = factor * value + offset."""

    symbol: str
    factor: float = 1.0
    offset: float = 0.0

    @overload
    def to_si(self, value: float) -> float: ...
    @overload
    def to_si(self, value: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def to_si(self, value):
        """Convert a number or an array (any shape) to SI. NaN stays NaN."""
        # Add only a nonzero offset: adding 0.0 would turn -0.0 into 0.0.
        return self.factor * value + self.offset if self.offset else self.factor * value


# One row for each unit: the unit, its other spellings where case matters ('mA' is not 'MA'), and
# its spellings where case does not matter. The first unit of a dimension is the one used inside and
# in outputs. '·' between the parts of a spelling may be omitted or be a dot, a blank or a star; a
# root may be written √h, sqrt(h) or h^0.5, and a quotient deg/h or deg·h^-1.
# Speeds have no Hz and no 1/s: these do not say whether radians or revolutions are counted.
Row = tuple[Unit, tuple[str, ...], tuple[str, ...]]
_ANGLES: tuple[Row, ...] = (
    (Unit("rad"), (), ("rad", "radian", "radians")),
    (Unit("deg", _DEGREE), (), ("deg", "°", "degree", "degrees")),
    (Unit("arcsec", _DEGREE / 3600.0), (), ("arcsec", "arcsecond", "arcseconds", "arc-sec")),
    (Unit("arcmin", _DEGREE / 60.0), (), ("arcmin", "arcminute", "arcminutes")),
    (Unit("mdeg", 1e-3 * _DEGREE), (), ()),
    (Unit("mrad", 1e-3), (), ()),
    (Unit("µrad", 1e-6), (), ()),
)
_SECOND, _HOUR, _HERTZ = ("s", "sec"), ("h", "hr", "hour"), ("Hz",)
Below = tuple[float, tuple[tuple[str, ...], ...]]
"""SI value of the denominators of a unit, and the spellings of each, the symbol first."""


def _per(*choices: Below, angles: tuple[Row, ...] = _ANGLES) -> tuple[Row, ...]:
    """Units of each angle over each choice of denominators, such as the root of an hour."""
    rows = []
    for (angle, _, free), (seconds, denominators) in itertools.product(angles, choices):
        below = ["/".join(names) for names in itertools.product(*denominators)]
        unit = Unit(f"{angle.symbol}/{below[0]}", angle.factor / seconds)
        strict = tuple(f"{angle.symbol}/{names}" for names in below)
        rows.append((unit, strict, tuple(f"{a}/{names}" for a in free for names in below)))
    return tuple(rows)


def _root(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"√{name}" for name in names)


TABLE: dict[str, tuple[Row, ...]] = {
    "time": (
        (Unit("s"), (), ("s", "sec", "second", "seconds")),
        (Unit("ms", 1e-3), (), ("msec", "millisecond", "milliseconds")),
        (Unit("µs", 1e-6), (), ("usec", "microsecond", "microseconds")),
        (Unit("ns", 1e-9), (), ("nsec", "nanosecond", "nanoseconds")),
        (Unit("min", 60.0), (), ("min", "minute", "minutes")),
        (Unit("h", 3600.0), (), ("h", "hr", "hour", "hours")),
        (Unit("d", 86400.0), (), ("d", "day", "days")),
    ),
    "current": (
        (Unit("A"), (), ("amp", "amps", "ampere", "amperes")),
        (Unit("mA", 1e-3), (), ("milliamp", "milliamps", "milliampere", "milliamperes")),
        (Unit("µA", 1e-6), (), ("microamp", "microamps", "microampere", "microamperes")),
    ),
    "power": (
        (Unit("W"), (), ("watt", "watts")),
        (Unit("mW", 1e-3), (), ("milliwatt", "milliwatts")),
    ),
    "resistance": (
        (Unit("Ohm"), ("Ω",), ("ohm", "ohms")),
        (Unit("mOhm", 1e-3), ("mohm", "mΩ"), ("milliohm", "milliohms")),
    ),
    "speed": (
        (Unit("rad/s"), (), ("rad/s", "rad/sec", "rad·s-1", "radians/s")),
        (Unit("deg/s", _DEGREE), (), ("deg/s", "deg/sec", "°/s", "°/sec", "deg·s-1", "degrees/s")),
        (Unit("rpm", RPM), (), ("rpm", "rev/min", "r/min", "1/min", "min-1", "U/min")),
        (Unit("rev/s", 2.0 * math.pi), (), ("rev/s", "rev/sec", "r/s", "rps")),
        *_per(
            *((1.0, (_SECOND,)), (3600.0, (_HOUR,)), (60.0, (("min", "minute"),))),
            angles=_ANGLES[1:] + _ANGLES[:1],
        ),
    ),
    "torque": (
        (Unit("N·m"), (), ()),
        (Unit("mN·m", 1e-3), (), ()),
        (Unit("µN·m", 1e-6), (), ()),
    ),
    "momentum": (
        (Unit("N·m·s"), ("kg·m2/s",), ()),
        (Unit("mN·m·s", 1e-3), (), ()),
        (Unit("µN·m·s", 1e-6), (), ()),
    ),
    "motor_constant": (
        (Unit("N·m/A"), ("N·m·A-1",), ()),
        (Unit("mN·m/A", 1e-3), ("mN·m·A-1",), ()),
    ),
    "inertia": (
        (Unit("kg·m²"), ("N·m·s2",), ()),
        (Unit("g·m²", 1e-3), (), ()),
        (Unit("kg·cm²", 1e-4), (), ()),
        (Unit("g·cm²", 1e-7), (), ()),
        (Unit("kg·mm²", 1e-6), (), ()),
        (Unit("g·mm²", 1e-9), (), ()),
    ),
    "mass": ((Unit("kg"), (), ()), (Unit("g", 1e-3), (), ())),
    "length": (
        (Unit("m"), (), ("metre", "metres", "meter", "meters")),
        (Unit("cm", 1e-2), (), ()),
        (Unit("mm", 1e-3), (), ()),
        (Unit("km", 1e3), (), ()),
    ),
    "area": ((Unit("m²"), (), ()), (Unit("cm²", 1e-4), (), ()), (Unit("mm²", 1e-6), (), ())),
    "magnetic_dipole": ((Unit("A·m²"), (), ()), (Unit("mA·m²", 1e-3), (), ())),
    "flux_density": (
        (Unit("T"), (), ("tesla",)),
        (Unit("mT", 1e-3), (), ()),
        (Unit("µT", 1e-6), (), ()),
        (Unit("nT", 1e-9), (), ()),
    ),
    "imbalance": (
        (Unit("kg·m"), (), ()),
        (Unit("g·cm", 1e-5), (), ()),
        (Unit("g·mm", 1e-6), (), ()),
    ),
    "viscous": (
        (Unit("N·m·s/rad"), ("N·m·s", "N·m/(rad/s)"), ()),
        (Unit("mN·m·s/rad", 1e-3), ("mN·m·s", "mN·m/(rad/s)"), ()),
        (Unit("µN·m·s/rad", 1e-6), ("uN·m·s", "uN·m/(rad/s)"), ()),
        (Unit("N·m/rpm", 1.0 / RPM), (), ()),
        (Unit("mN·m/rpm", 1e-3 / RPM), (), ()),
        (Unit("µN·m/rpm", 1e-6 / RPM), (), ()),
    ),
    "stiffness": (
        (Unit("N·m/rad"), (), ()),
        (Unit("mN·m/rad", 1e-3), (), ()),
        (Unit("µN·m/rad", 1e-6), (), ()),
    ),
    "torque_per_temperature": ((Unit("N·m/°C"), (), ()),),
    "viscous_per_temperature": ((Unit("N·m·s/rad/°C"), (), ()),),
    "temperature": (
        (Unit("°C"), ("C",), ("°C", "degC", "deg·C", "Celsius")),
        (Unit("K", 1.0, -273.15), (), ("Kelvin",)),
        (Unit("°F", 5.0 / 9.0, -160.0 / 9.0), ("F",), ("°F", "degF", "deg·F", "Fahrenheit")),
    ),
    "frequency": ((Unit("Hz"), (), ("Hz", "hertz")), (Unit("mHz", 1e-3), ("mHz",), ())),
    "angle": (
        *_ANGLES,
        (Unit("rev", 2.0 * math.pi), (), ("rev", "turn", "turns", "revolution", "revolutions")),
    ),
    # A density in deg/s/√Hz is that of the two-sided spectrum (IEEE Std 952).
    "angle_random_walk": _per(
        (1.0, (_root(_SECOND),)),
        (60.0, (_root(_HOUR),)),
        (1.0, (_SECOND, _root(_HERTZ))),
        (3600.0, (_HOUR, _root(_HERTZ))),
    ),
    "rate_random_walk": _per(
        (1.0, (_SECOND, _root(_SECOND))),
        (216000.0, (_HOUR, _root(_HOUR))),
        (60.0, (_SECOND, _root(_HOUR))),
        (3600.0, (_HOUR, _root(_SECOND))),
        (1.0, (("s√s",),)),
        (216000.0, (("h√h", "hr√hr"),)),
    ),
}
