"""Read tables of a scenario file; errors name the full path of the key."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from gyrostat.campaigns.schema import Key
from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import name_text, number, quantity, read_toml, refuse_unknown
from gyrostat.core.units import SI_UNIT

UNIT = 1e-3
"""Of the length of a quaternion: written with few digits, it is brought to unit length."""


@dataclass(frozen=True)
class Table:
    """One table of a file.

    Attributes:
        path: of the file.
        prefix: of its keys, "run." for those of [run].
        row: as TOML gives it.
    """

    path: Path
    prefix: str
    row: dict[str, Any]

    def place(self, key: str) -> str:
        """Where a key is, for messages."""
        return f"{self.path}: key {self.prefix}{key}"

    def refuse(self, key: str, found: object, expected: str) -> InputError:
        """The error for the value of a key."""
        shown = repr(found)
        shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
        return InputError(f"{self.place(key)}: found {shown}, expected {expected}")

    def known(self, keys: Collection[str]) -> Self:
        """Itself, once no key is another than these."""
        refuse_unknown(self.path, self.prefix, self.row, keys)
        return self

    def table(self, name: str, keys: Collection[str] | None) -> "Table":
        """A table within, empty where there is none, of known keys unless None."""
        found = self.row.get(name, {})
        if not isinstance(found, dict):
            raise self.refuse(name, found, f"a table [{self.prefix}{name}]")
        inner = Table(self.path, f"{self.prefix}{name}.", found)
        return inner if keys is None else inner.known(keys)

    def tables(self, name: str) -> list["Table"]:
        """Tables [[name]], none where there are none."""
        found = self.row.get(name, [])
        if not isinstance(found, list) or not all(isinstance(row, dict) for row in found):
            raise self.refuse(name, found, f"tables [[{self.prefix}{name}]]")
        return [Table(self.path, f"{self.prefix}{name}[{k}].", row) for k, row in enumerate(found)]

    def text(self, key: str, default: str | None) -> str:
        """A text; required where the default is None."""
        found = self.row.get(key, default)
        if not isinstance(found, str):
            raise self.refuse(key, found, "a text")
        return found

    def one_of(self, key: str, kinds: Collection[str], default: str | None = None) -> str:
        """One of several names; required where the default is None."""
        found = self.text(key, default)
        if found not in kinds:
            raise self.refuse(key, found, f"one of {', '.join(kinds)}")
        return found

    def name(self, key: str, default: str) -> str:
        """A name that figures and tables show."""
        return name_text(self.path, f"{self.prefix}{key}", self.row.get(key, default))

    def value(self, key: str, found: object, dimension: str, *, positive: bool) -> float:
        """A number of a dimension, SI; a plain one where the dimension is a unit."""
        where = f"{self.prefix}{key}"
        if dimension in SI_UNIT:
            return quantity(self.path, where, found, dimension, positive=positive)
        return number(self.path, where, found, positive=positive)

    def quantity(self, key: str, dimension: str, *, positive: bool) -> float:
        """A number of a dimension, SI."""
        return self.value(key, self.row.get(key), dimension, positive=positive)

    def allowed(self, key: str, found: object, entry: Key) -> float:
        """A number that an entry of the schema allows, SI."""
        value = self.value(key, found, entry.dimension, positive=False)
        if not entry.allows(value):
            raise self.refuse(key, found, entry.range(value))
        return value

    def number(self, key: str, entry: Key, found: Any, full: str) -> dict[str, float]:
        """Full keys -> values, SI, of what is found at a key: one, or the components of a vector.

        Args:
            key: In the file.
            entry: Of the schema.
            found: As TOML gives it; None for the default.
            full: Key of the scenario, without the axis of a component.
        """
        default = entry.default
        if found is None and default is not None:
            return dict.fromkeys(entry.ends(full), default)
        if found is None:
            raise InputError(f"{self.place(key)}: found none, expected {entry.range()}")
        if entry.size == 1:
            return {full: self.allowed(key, found, entry)}
        if not isinstance(found, list) or len(found) != entry.size:
            raise self.refuse(key, found, f"{entry.size} values")
        return {
            end: self.allowed(f"{key}[{k}]", part, entry)
            for k, (end, part) in enumerate(zip(entry.ends(full), found, strict=True))
        }

    def numbers(self, keys: Mapping[str, Key], section: str | None = None) -> dict[str, float]:
        """Full keys -> values, SI, of all entries of a schema.

        Args:
            keys: Entries of the schema.
            section: Start of the full keys, "event.NAME."; None for that of the keys in the file.
        """
        start, found = self.prefix if section is None else section, {}
        for name, entry in keys.items():
            found |= self.number(name, entry, self.row.get(name), start + name)
        return found

    def each(self, name: str, entry: Key, wheels: Collection[str]) -> dict[str, float]:
        """Full keys of the wheels -> values, SI: given once for all wheels, or once for each."""
        given: Any = self.row.get(name)
        listed = isinstance(given, list)
        if listed and entry.size > 1:
            listed = any(isinstance(value, list) for value in given)
        rows = given if listed else [given] * len(wheels)
        if len(rows) != len(wheels):
            raise InputError(
                f"{self.place(name)}: found {len(rows)} values, expected one or {len(wheels)}, one "
                "a wheel"
            )
        found = {}
        for k, (wheel, value) in enumerate(zip(wheels, rows, strict=True)):
            key = f"{name}[{k}]" if listed else name
            found |= self.number(key, entry, value, f"wheel.{wheel}.{name}")
        return found

    def unit(self, key: str, size: int, default: tuple[float, ...] | None) -> tuple[float, ...]:
        """A unit vector: a quaternion is checked, a direction may have any length."""
        found = self.row.get(key, default)
        if not isinstance(found, list | tuple) or len(found) != size:
            what = "a quaternion of four numbers, scalar first" if size == 4 else "three numbers"
            raise self.refuse(key, found, what)
        parts = [self.value(f"{key}[{k}]", v, "1", positive=False) for k, v in enumerate(found)]
        length = math.hypot(*parts)
        if size == 4 and not abs(length - 1.0) < UNIT:
            raise self.refuse(key, found, "a quaternion of unit length")
        if not 0.0 < length < math.inf:
            raise self.refuse(key, found, "a direction")
        return tuple(part / length for part in parts)

    def whole(self, key: str, default: int, most: int) -> int:
        """A whole number from 0 on."""
        found = self.row.get(key, default)
        if not isinstance(found, int) or isinstance(found, bool) or not 0 <= found <= most:
            raise self.refuse(key, found, f"a whole number from 0 to {most}")
        return found

    def rising(
        self, key: str, default: tuple[float, ...], low: float, high: float
    ) -> tuple[float, ...]:
        """Some numbers strictly between two, rising."""
        found = self.row.get(key, list(default))
        if not isinstance(found, list) or not found:
            raise self.refuse(key, found, f"numbers between {low:g} and {high:g}")
        parts = tuple(
            self.value(f"{key}[{k}]", v, "1", positive=False) for k, v in enumerate(found)
        )
        if list(parts) != sorted(set(parts)) or not low < parts[0] <= parts[-1] < high:
            raise self.refuse(key, found, f"rising numbers between {low:g} and {high:g}")
        return parts

    def multiple(self, key: str, value: float, name: str, part: float, most: int) -> int:
        """How often a part goes into a key's value, which must be a whole number of times."""
        times = value / part if part * most > value else math.inf
        if not (0.5 < times <= most and abs(times - round(times)) < 1e-6 * times):
            raise self.refuse(
                key, value, f"a whole multiple of the {name}, {part:g} s, at most {most} of them"
            )
        return round(times)


def opened(path: Path, kind: str, sections: Collection[str]) -> Table:
    """The whole of a file, of known sections."""
    return Table(path, "", read_toml(path, kind)).known(sections)
