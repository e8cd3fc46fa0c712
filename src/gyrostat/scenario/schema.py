"""Keys of a scenario file: dimension, default and meaning of each."""

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, nan
from typing import TYPE_CHECKING

from gyrostat.core.any_unit import ANY_UNIT
from gyrostat.core.units import SI_UNIT
from gyrostat.core.validation import LARGEST
from gyrostat.scenario.scenario import AXES

if TYPE_CHECKING:
    from gyrostat.wheel.friction_laws import Law


@dataclass(frozen=True)
class Key:
    """Entry of the schema: a number or array in a scenario.

    It describes a field of a user-defined part: `Annotated[float, Key("N·m", least=0.0)]`.

    Attributes:
        dimension: Key of `gyrostat.core.units.SI_UNIT`; or `ANY_UNIT`; or the SI unit of a number
            that is given without unit. For a field of a user-defined part, the SI unit in any case.
        default: Default value, SI, one for all components or one for each; None if the key is
            required.
        meaning: One sentence for the documentation.
        least: Smallest allowed value.
        most: Largest allowed value.
        positive: Whether `least` itself is excluded.
        shape: Shape of an array; () for a number.
        unlimited: Whether the value may be infinite, the text "none" in a file. It always may be
            if that is the default.
        source: Source of pointing error that the number is a size of, such as "noise"; numbers of
            one place with the same source are switched off together. Empty: of none.
        without: Value without this source; None: a millionth of the value, whose effect in mean
            square is 1e-12 of that of the value.
        is_text: Whether the number stands for a text, so that it is not dispersed.
        is_direction: Whether a vector must not be zero.
    """

    dimension: str
    default: float | tuple[float, ...] | None = None
    meaning: str = ""
    least: float = -inf
    most: float = inf
    positive: bool = False
    shape: tuple[int, ...] = ()
    unlimited: bool = False
    source: str = ""
    without: float | None = None
    is_text: bool = False
    is_direction: bool = False

    @property
    def unit(self) -> str:
        """SI unit; empty if it is not known."""
        if self.dimension == ANY_UNIT:
            return ""
        return SI_UNIT.get(self.dimension, self.dimension)

    def ends(self, name: str) -> tuple[str, ...]:
        """Full keys of a number, or of the components of an array, with this name."""
        if self.shape == (3,):
            return tuple(f"{name}.{axis}" for axis in AXES)
        indices = itertools.product(*map(range, self.shape))
        return tuple(".".join((name, *map(str, index))) for index in indices)

    def defaults(self) -> tuple[float, ...]:
        """Default value of each component; empty if the key is required."""
        if self.default is None or isinstance(self.default, tuple):
            return self.default or ()
        return (self.default,) * math.prod(self.shape)

    def allows(self, value: float) -> bool:
        """Whether a value is allowed; NaN is not."""
        inside = self.least <= value <= self.most and not (self.positive and value == self.least)
        special = value in self.defaults() or (self.unlimited and value == inf)
        return inside and (abs(value) <= LARGEST or special)

    def range(self, found: float = nan) -> str:
        """Allowed values, for an error message about the value `found`."""
        unit = "" if self.unit in ("", "1") else f", in {self.unit}"
        if abs(found) > LARGEST:
            return f"a size of {LARGEST:g} or less{unit}"
        if self.least == -inf:
            return f"a finite number{unit}" if self.most == inf else f"at most {self.most:g}{unit}"
        bound = f"above {self.least:g}" if self.positive else f"{self.least:g} or more"
        return f"{bound}{'' if self.most == inf else f', at most {self.most:g}'}{unit}"


def positive(
    dimension: str, default: float | None, meaning: str, most: float = inf, source: str = ""
) -> Key:
    """Key with values above 0."""
    return Key(dimension, default, meaning, 0.0, most, positive=True, source=source)


def size(
    dimension: str, default: float | None, meaning: str, most: float = inf, source: str = ""
) -> Key:
    """Key with values of 0 or more."""
    return Key(dimension, default, meaning, 0.0, most, source=source)


def vector(
    dimension: str, meaning: str, default: float | tuple[float, ...] = 0.0, source: str = ""
) -> Key:
    """Key of a vector in body axes, (3,), zero by default."""
    return Key(dimension, default, meaning, shape=(3,), source=source)


def direction(meaning: str, default: float | tuple[float, ...] | None = (0.0, 0.0, 1.0)) -> Key:
    """Key of a vector in body axes of any length but zero, (3,), z by default."""
    return Key("1", default, meaning, shape=(3,), is_direction=True)


def between_poles(meaning: str, default: float | None = None) -> Key:
    """Key of an angle between both poles."""
    return Key("angle", default, meaning, -1.5708, 1.5708)


RUN: dict[str, Key] = {
    "duration": positive("time", None, "Duration of a run; a whole number of control periods."),
    "control_period": positive("time", None, "Time between samples, and between commands."),
}
START: dict[str, Key] = {
    "attitude_error": vector("angle", "Rotation vector from `attitude` to the initial attitude."),
    "rate": vector("speed", "Initial body rate, in body axes."),
}
NEVER = 1e12
"""Time after the end of every run, s."""
EVENT_TIME = Key("time", None, "Time of the event.", least=0.0, source="event", without=NEVER)
Measured = tuple[str, str | None]
"""Dimension of a measured field, and the unit of its rate of change; see `MEASURED`."""
MEASURED: dict[str, Measured] = {
    "attitude": ("1", None),
    "rate": ("speed", "rad/s²"),
    "wheel_speed": ("speed", "rad/s²"),
}
"""Measured field -> its dimension, and the unit of its rate of change. The unit is None for a
quaternion, whose sign may change from one sample to the next."""


def guard_keys(fields: Mapping[str, Measured]) -> dict[str, Key]:
    """Keys of the measurement limits.

    Args:
        fields: Measured field -> its dimension, and the unit of its rate of change, see `MEASURED`.
    """
    keys = {f"{n}_lower": Key(d, -inf, "Smallest accepted value.") for n, (d, _) in fields.items()}
    keys |= {f"{n}_upper": Key(d, inf, "Largest accepted value.") for n, (d, _) in fields.items()}
    # closer limits would reject attitudes: a component of a quaternion can be -1 or 1
    keys["attitude_lower"] = replace(keys["attitude_lower"], most=-1.0)
    keys["attitude_upper"] = replace(keys["attitude_upper"], least=1.0)
    return keys | {
        f"{name}_change": positive(unit, inf, "Largest accepted rate of change.")
        for name, (_, unit) in fields.items()
        if unit is not None
    }


GUARD = guard_keys(MEASURED)
"""Keys of the measurement limits without further sensors."""
INERTIA = Key(
    "inertia", None, "Body inertia, without the inertia of the rotors about their spin axes."
)
CENTRE_OF_MASS = vector("length", "Centre of mass, from the origin of the body axes.")
BODY = {"mass": positive("mass", None, "Mass with the wheels."), "centre_of_mass": CENTRE_OF_MASS}
"""Keys of the body that a spacecraft file may have."""


FRICTION = "friction"
"""Source of pointing error whose numbers are the friction torques of a wheel."""


def friction_keys(law: "Law") -> dict[str, Key]:
    """Keys of the parameters of a friction law."""
    meaning = "Friction parameter."
    keys = {
        name: Key(dimension, None, meaning)
        if name in law.signed()
        else (positive if dimension in ("speed", "stiffness") else size)(dimension, None, meaning)
        for name, dimension in law.dimensions().items()
    }
    # a torque is proportional to all of its coefficients together, bristles included
    return {
        name: replace(key, source=FRICTION) if key.unit.startswith("N·m") else key
        for name, key in keys.items()
    }
