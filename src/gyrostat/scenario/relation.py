"""Condition that several values of a scenario fulfil together."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from gyrostat.core.errors import InputError


class Relation(NamedTuple):
    """Condition that several values fulfil together.

    Attributes:
        keys: Keys of the values.
        text: Message if they do not: place, what was found and what is expected; `{KEY}` stands for
            a value.
        holds: Whether it holds, from a mapping of keys to values. It uses operators and functions
            of NumPy, elementwise, so that it is evaluated for many runs at once, and compiled.
    """

    keys: tuple[str, ...]
    text: str
    holds: Callable[[Mapping[str, Any]], Any]

    def message(self, values: Mapping[str, float]) -> str:
        """Message about values that do not fulfil it."""
        text = self.text
        for key in self.keys:  # names in a text may have braces
            text = text.replace(f"{{{key}}}", f"{values[key]:g}")
        return text


def less(low: str, high: str, text: str) -> Relation:
    """Relation of a value below another one.

    Args:
        low: Key of the smaller value.
        high: Key of the larger value.
        text: See `Relation`.
    """
    return Relation((low, high), text, lambda values: values[low] < values[high])


def has_direction(key: str) -> Relation:
    """Relation of the components of a vector, which is not zero.

    Args:
        key: Key of the vector.
    """
    keys = tuple(f"{key}.{axis}" for axis in "xyz")
    text = f"{key}: found no direction, expected a vector"
    return Relation(
        keys, text, lambda values: sum(values[each] * values[each] for each in keys) > 0.0
    )


def check_relations(relations: Iterable[Relation], values: Mapping[str, float]) -> None:
    """Check that values fulfil all relations.

    Raises:
        InputError: They do not; the message is that of the first.
    """
    for relation in relations:
        if not relation.holds(values):
            raise InputError(f"key {relation.message(values)}")
