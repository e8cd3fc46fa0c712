"""Parts whose parameters declare at the field what they may be.

    class Lag(Checked):
        time_constant: Annotated[Scalar, positive("time constant", "s")] = 0.1

A rule tests the value of its field, one or one for each run, and raises `InputError`.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import equinox as eqx
import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.show import with_values
from gyrostat.core.validation import check_parts, check_period, require


@dataclasses.dataclass(frozen=True, repr=False)
class Rule:
    """What the value of a field may be.

    Attributes:
        wanted: In words, as signatures show it.
        test: Raises `InputError` for any other value.
    """

    wanted: str
    test: Callable[[Any], None]

    def __repr__(self) -> str:
        return self.wanted


def positive(name: str, unit: str = "") -> Rule:
    """Finite and above 0; `name` and `unit` are for the message."""
    return Rule(f"above 0 {unit}".rstrip(), lambda value: require(name, value, unit, positive=True))


def size(name: str, unit: str = "") -> Rule:
    """Finite, 0 or more; `name` and `unit` are for the message."""
    return Rule(f"0 or more {unit}".rstrip(), lambda value: require(name, value, unit))


def signed(name: str, unit: str = "") -> Rule:
    """Finite, of either sign; `name` and `unit` are for the message."""
    return Rule(f"finite {unit}".rstrip(), lambda value: require(name, np.abs(value), unit))


def within(name: str, wanted: str, sound: Callable[[np.ndarray], Any], unit: str = "") -> Rule:
    """Every element passes a test; comparisons with NaN are false.

    Args:
        name: For the message.
        wanted: What is expected, for the message.
        sound: Elements -> whether each may be.
        unit: Of the elements, for the message.
    """

    def test(value: Any) -> None:
        every = np.asarray(value, dtype=float)
        bad = ~np.asarray(sound(every))
        if np.any(bad):
            found = f"{every[bad].flat[0]:g} {unit}".rstrip()
            raise InputError(f"{name}: found {found}, expected {wanted}")

    return Rule(wanted, test)


def finite(name: str, unit: str) -> Rule:
    """Finite; `name` and `unit` are for the message."""
    return within(name, f"a finite value, {unit}", np.isfinite)


def from_start(name: str) -> Rule:
    """A time, s, of 0 or later, infinite for never; `name` is for the message."""
    return within(name, "0 s (the start) or later", lambda value: value >= 0.0, "s")


def limit(name: str, unit: str) -> Rule:
    """Above 0, infinite for no limit; `name` and `unit` are for the message."""
    return within(name, f"above 0 {unit}", lambda value: value > 0.0)


def share(name: str) -> Rule:
    """In [0, 1]; `name` is for the message."""
    return within(name, "0 to 1", lambda value: (value >= 0.0) & (value <= 1.0))


def positive_share(name: str) -> Rule:
    """In (0, 1]; `name` is for the message."""
    return within(name, "in (0, 1]", lambda value: (value > 0.0) & (value <= 1.0))


def three(name: str, unit: str = "") -> Rule:
    """(3,) finite values; `name` and `unit` are for the message."""
    wanted = ", ".join(filter(None, ("three finite values", unit)))

    def test(value: Any) -> None:
        every = np.asarray(value, dtype=float)
        if every.shape[-1:] != (3,) or not np.all(np.isfinite(every)):
            raise InputError(f"{name}: found {every}, expected {wanted}")

    return Rule(wanted, test)


class Checked(eqx.Module):
    """A part of the loop that validates its parameters.

    A field may declare rules by `typing.Annotated`; a field that is None is not tested. Fields that
    are parts themselves validate their own.
    """

    def __repr__(self) -> str:
        return with_values(self)

    def check(self) -> None:
        """Validate parameters: every field, then `check_own`.

        Raises:
            InputError: A field breaks its rule, or a part or `check_own` refuses.
        """
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            for rule in getattr(field.type, "__metadata__", ()):
                if isinstance(rule, Rule) and value is not None:
                    rule.test(value)
            check_parts(*_each(value))
        self.check_own()

    def check_own(self) -> None:
        """Validate what takes more than the rule of a field; nothing unless a part has such.

        Raises:
            InputError: See the part.
        """

    def check_period(self, period: float) -> None:
        """Validate parts, then parameters of its own, at a control period.

        Args:
            period: s.

        Raises:
            InputError: A part or `check_own_period` refuses.
        """
        for field in dataclasses.fields(self):
            check_period(period, *_each(getattr(self, field.name)))
        self.check_own_period(period)

    def check_own_period(self, period: float) -> None:
        """Validate parameters of its own at a control period; nothing unless a part has such.

        Args:
            period: s.

        Raises:
            InputError: See the part.
        """


def _each(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def declared_units(kind: type) -> dict[str, str]:
    """Field -> unit of a class that declares units.

    Either the annotation of a field is `Annotated[type, unit]`, or `UNITS` of the class has them.

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
