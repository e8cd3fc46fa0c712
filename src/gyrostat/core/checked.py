"""Validation of parameters by rules in the annotations of their fields.

    class Lag(Checked):
        time_constant: Annotated[Scalar, positive("time constant", "s")] = 0.1

A rule tests the value of its field, for one run or for a batch, and raises `InputError`.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.show import with_values
from gyrostat.core.validation import check_parts, check_period, require


@dataclasses.dataclass(frozen=True, repr=False)
class Rule:
    """Rule for the allowed values of a field.

    Attributes:
        wanted: Allowed values in words, shown in signatures.
        test: Function of the value; raises `InputError` for a value that is not allowed.
    """

    wanted: str
    test: Callable[[Any], None]

    def __repr__(self) -> str:
        return self.wanted


def positive(name: str, unit: str = "") -> Rule:
    """Rule: finite and above 0; `name` and `unit` are for the message."""
    return Rule(f"above 0 {unit}".rstrip(), lambda value: require(name, value, unit, positive=True))


def size(name: str, unit: str = "") -> Rule:
    """Rule: finite, 0 or more; `name` and `unit` are for the message."""
    return Rule(f"0 or more {unit}".rstrip(), lambda value: require(name, value, unit))


def signed(name: str, unit: str = "") -> Rule:
    """Rule: finite, of either sign; `name` and `unit` are for the message."""
    return Rule(f"finite {unit}".rstrip(), lambda value: require(name, np.abs(value), unit))


def within(name: str, wanted: str, sound: Callable[[np.ndarray], Any], unit: str = "") -> Rule:
    """Rule: every element passes a test.

    Args:
        name: Name of the parameter, for the message.
        wanted: Expected values, for the message.
        sound: Elements -> whether each is allowed. Comparisons with NaN are false, so that NaN is
            refused.
        unit: Unit of the elements, for the message.
    """

    def test(value: Any) -> None:
        every = np.asarray(value, dtype=float)
        bad = ~np.asarray(sound(every))
        if np.any(bad):
            found = f"{every[bad].flat[0]:g} {unit}".rstrip()
            raise InputError(f"{name}: found {found}, expected {wanted}")

    return Rule(wanted, test)


def finite(name: str, unit: str) -> Rule:
    """Rule: finite; `name` and `unit` are for the message."""
    return within(name, f"a finite value, {unit}", np.isfinite)


def from_start(name: str) -> Rule:
    """Rule: time, s, of 0 or later, infinite for never; `name` is for the message."""
    return within(name, "0 s (the start) or later", lambda value: value >= 0.0, "s")


def limit(name: str, unit: str) -> Rule:
    """Rule: above 0, infinite for no limit; `name` and `unit` are for the message."""
    return within(name, f"above 0 {unit}", lambda value: value > 0.0)


def share(name: str) -> Rule:
    """Rule: in [0, 1]; `name` is for the message."""
    return within(name, "0 to 1", lambda value: (value >= 0.0) & (value <= 1.0))


def positive_share(name: str) -> Rule:
    """Rule: in (0, 1]; `name` is for the message."""
    return within(name, "in (0, 1]", lambda value: (value > 0.0) & (value <= 1.0))


def three(name: str, unit: str = "") -> Rule:
    """Rule: three finite values, (3,); `name` and `unit` are for the message."""
    expected = ", ".join(filter(None, ("three finite values", unit)))

    def test(value: Any) -> None:
        every = np.asarray(value, dtype=float)
        if every.shape[-1:] != (3,) or not np.all(np.isfinite(every)):
            raise InputError(f"{name}: found {every}, expected {expected}")

    return Rule(expected, test)


def direction(name: str) -> Rule:
    """Rule: a vector with a direction, neither zero nor NaN; `name` is for the message."""

    def test(value: Any) -> None:
        if not np.all(np.linalg.norm(np.asarray(value, dtype=float), axis=-1) > 0.0):
            raise InputError(f"{name}: found no direction, expected a vector")

    return Rule("a direction", test)


class Checked(eqx.Module, Described):
    """Base class of plants, sensors, controllers and other parts that validate their parameters.

    A field declares rules by `typing.Annotated`; a field that is None is not tested. Fields that
    are parts themselves validate their own parameters.
    """

    def __repr__(self) -> str:
        return with_values(self)

    def check(self) -> None:
        """Validate parameters: every field by its rules, then by `check_own`.

        Raises:
            InputError: A field breaks its rule, or a part or `check_own` raises it.
        """
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            for rule in getattr(field.type, "__metadata__", ()):
                if isinstance(rule, Rule) and value is not None:
                    rule.test(value)
            check_parts(*_as_tuple(value))
        self.check_own()

    def check_own(self) -> None:
        """Validate parameters beyond the rules of single fields; does nothing by default.

        Raises:
            InputError: See the part.
        """

    def check_period(self, period: float) -> None:
        """Validate the control period: every field that is a part, then `check_own_period`.

        Args:
            period: Control period, s.

        Raises:
            InputError: A part or `check_own_period` raises it.
        """
        for field in dataclasses.fields(self):
            check_period(period, *_as_tuple(getattr(self, field.name)))
        self.check_own_period(period)

    def check_own_period(self, period: float) -> None:
        """Validate the control period against own parameters; does nothing by default.

        Args:
            period: Control period, s.

        Raises:
            InputError: See the part.
        """


def _as_tuple(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def declared_units(kind: type) -> dict[str, str]:
    """Units that a class declares for its fields: field -> unit.

    A unit is declared by the annotation `Annotated[type, unit]`, or in `UNITS` of the class.

    Args:
        kind: Class of a state, command, measurement or record.
    """
    annotated = {
        name: note
        for name, annotation in getattr(kind, "__annotations__", {}).items()
        for note in getattr(annotation, "__metadata__", ())
        if isinstance(note, str)
    }
    return annotated | getattr(kind, "UNITS", {})
