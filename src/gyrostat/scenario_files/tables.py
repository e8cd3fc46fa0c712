"""Typed reading of the tables of a scenario file; error messages contain the full key."""

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from gyrostat.core.any_unit import ANY_UNIT, parse_any
from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import name_text, number, quantity, read_toml, refuse_unknown
from gyrostat.core.units import QUANTITY, SI_UNIT, ascii_number
from gyrostat.scenario.schema import Key

UNIT = 1e-3
"""Largest deviation of the length of a quaternion from 1; it is then normalised."""


@dataclass(frozen=True)
class Table:
    """Table of a TOML file, with validation of its values.

    Attributes:
        path: Path of the file.
        prefix: Prefix of the keys, such as "run." for the table [run].
        row: Content of the table from the TOML parser.
    """

    path: Path
    prefix: str
    row: dict[str, Any]

    def place(self, key: str) -> str:
        """File and full name of a key, for error messages."""
        return f"{self.path}: key {self.prefix}{key}"

    def refuse(self, key: str, found: object, expected: str) -> InputError:
        """Create the error for an invalid value of a key."""
        text = repr(found)
        text = text if len(text) <= 60 else f"{text[:57]}..."
        return InputError(f"{self.place(key)}: found {text}, expected {expected}")

    def known(self, keys: Collection[str]) -> Self:
        """Return the table itself if it has no other keys than these; raises `InputError`."""
        refuse_unknown(self.path, self.prefix, self.row, keys)
        return self

    def table(self, name: str, keys: Collection[str] | None) -> "Table":
        """Read a subtable, empty if missing; its keys are validated unless `keys` is None."""
        content = self.row.get(name, {})
        if not isinstance(content, dict):
            raise self.refuse(name, content, f"a table [{self.prefix}{name}]")
        inner = Table(self.path, f"{self.prefix}{name}.", content)
        return inner if keys is None else inner.known(keys)

    def with_missing(self, defaults: Mapping[str, object]) -> "Table":
        """Table whose missing keys have these values."""
        return Table(self.path, self.prefix, {**defaults, **self.row})

    def tables(self, name: str) -> list["Table"]:
        """Read the tables [[name]]; an empty list if there are none."""
        rows = self.row.get(name, [])
        if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
            raise self.refuse(name, rows, f"tables [[{self.prefix}{name}]]")
        return [Table(self.path, f"{self.prefix}{name}[{k}].", row) for k, row in enumerate(rows)]

    def text(self, key: str, default: str | None) -> str:
        """Read a text; required if the default is None."""
        text = self.row.get(key, default)
        if not isinstance(text, str):
            raise self.refuse(key, text, "a text")
        return text

    def flag(self, key: str) -> bool:
        """Read true or false; false by default."""
        value = self.row.get(key, False)
        if not isinstance(value, bool):
            raise self.refuse(key, value, "true or false")
        return value

    def one_of(self, key: str, kinds: Collection[str], default: str | None = None) -> str:
        """Read one of several names; required if the default is None."""
        name = self.text(key, default)
        if name not in kinds:
            raise self.refuse(key, name, f"one of {', '.join(kinds)}")
        return name

    def name(self, key: str, default: str) -> str:
        """Read a name for figures and tables."""
        return name_text(self.path, f"{self.prefix}{key}", self.row.get(key, default))

    def unique_name(
        self, default: str, taken: Collection[str], expected: str = "a unique name without a dot"
    ) -> str:
        """Read a name that is a part of keys and not taken."""
        name = self.name("name", default)
        if not name or "." in name or name in taken:
            raise InputError(f"{self.place('name')}: found {name!r}, expected {expected}")
        return name

    def value(self, key: str, found: object, dimension: str, *, positive: bool) -> float:
        """Convert a value with a dimension to SI; if the dimension is a unit, only of this unit."""
        full_key = f"{self.prefix}{key}"
        if dimension == ANY_UNIT and isinstance(found, str):
            return parse_any(found, self.place(key))
        if dimension in SI_UNIT or (isinstance(found, str) and QUANTITY.fullmatch(found)):
            return quantity(self.path, full_key, found, dimension, positive=positive)
        return number(self.path, full_key, found, positive=positive)

    def quantity(self, key: str, dimension: str, *, positive: bool) -> float:
        """Read a number with a dimension, SI."""
        return self.value(key, self.row.get(key), dimension, positive=positive)

    def allowed(self, key: str, found: object, entry: Key) -> float:
        """Convert a value to SI, "none" to infinity, and validate it by an entry of the schema."""
        if found == "none" and entry.allows(math.inf):
            return math.inf
        value = self.value(key, found, entry.dimension, positive=False)
        if not entry.allows(value):
            raise self.refuse(key, found, entry.range(value))
        return value

    def number(self, key: str, entry: Key, found: Any, full: str) -> dict[str, float]:
        """Convert a number or a vector: full keys of its components -> values, SI.

        Args:
            key: Key in the file.
            entry: Entry of the schema.
            found: Value from the TOML parser; None for the default.
            full: Key of the scenario, without the axis of a component.
        """
        ends = entry.ends(full)
        if found is None and entry.default is not None:
            return dict(zip(ends, entry.defaults(), strict=True))
        if found is None:
            raise InputError(f"{self.place(key)}: found none, expected {entry.range()}")
        parts = self._components(key, found, entry.shape)
        return {
            end: self.allowed(place, part, entry)
            for end, (place, part) in zip(ends, parts, strict=True)
        }

    def _components(
        self, key: str, value: Any, shape: tuple[int, ...]
    ) -> Iterator[tuple[str, object]]:
        """Places and values of the components of an array, from nested lists."""
        if not shape:
            yield key, value
            return
        if not isinstance(value, list) or len(value) != shape[0]:
            raise self.refuse(key, value, f"{shape[0]} values")
        for k, part in enumerate(value):
            yield from self._components(f"{key}[{k}]", part, shape[1:])

    def numbers(self, keys: Mapping[str, Key], section: str | None = None) -> dict[str, float]:
        """Read all entries of a schema: full keys -> values, SI.

        Args:
            keys: Entries of the schema.
            section: Prefix of the full keys, such as "event.NAME."; by default the prefix in the
                file.
        """
        start, values = self.prefix if section is None else section, {}
        for name, entry in keys.items():
            values |= self.number(name, entry, self.row.get(name), start + name)
        return values

    def each(self, name: str, entry: Key, wheels: Collection[str]) -> dict[str, float]:
        """Read one value for all wheels, or one for each: full keys of the wheels -> values, SI."""
        content: Any = self.row.get(name)
        is_list = isinstance(content, list)
        if is_list and entry.shape:
            is_list = any(isinstance(value, list) for value in content)
        rows = content if is_list else [content] * len(wheels)
        if len(rows) != len(wheels):
            raise InputError(
                f"{self.place(name)}: found {len(rows)} values, expected one or {len(wheels)}, one "
                "a wheel"
            )
        values = {}
        for k, (wheel, value) in enumerate(zip(wheels, rows, strict=True)):
            key = f"{name}[{k}]" if is_list else name
            values |= self.number(key, entry, value, f"wheel.{wheel}.{name}")
        return values

    def percentage(self, key: str) -> float | None:
        """Read a text such as "20 %" as a fraction; None for any other value."""
        text = self.row.get(key)
        if not isinstance(text, str) or not text.rstrip().endswith("%"):
            return None
        try:
            share = ascii_number(text.rstrip().removesuffix("%")) / 100.0
        except ValueError:
            share = math.nan
        if not math.isfinite(share):
            raise self.refuse(key, text, "a percentage such as '20 %'")
        return share

    def unit(self, key: str, size: int, default: tuple[float, ...] | None) -> tuple[float, ...]:
        """Read a unit quaternion (size 4), or normalise a direction of any length (size 3)."""
        vector = self.row.get(key, default)
        if not isinstance(vector, list | tuple) or len(vector) != size:
            form = "a quaternion of four numbers, scalar first" if size == 4 else "three numbers"
            raise self.refuse(key, vector, form)
        parts = [self.value(f"{key}[{k}]", v, "1", positive=False) for k, v in enumerate(vector)]
        length = math.hypot(*parts)
        if size == 4 and not abs(length - 1.0) < UNIT:
            raise self.refuse(key, vector, "a quaternion of unit length")
        if not 0.0 < length < math.inf:
            raise self.refuse(key, vector, "a direction")
        return tuple(part / length for part in parts)

    def whole(self, key: str, default: int, most: int) -> int:
        """Read a whole number from 0 to `most`."""
        count = self.row.get(key, default)
        if not isinstance(count, int) or isinstance(count, bool) or not 0 <= count <= most:
            raise self.refuse(key, count, f"a whole number from 0 to {most}")
        return count

    def rising(
        self, key: str, default: tuple[float, ...], low: float, high: float
    ) -> tuple[float, ...]:
        """Read increasing numbers strictly between `low` and `high`."""
        numbers = self.row.get(key, list(default))
        if not isinstance(numbers, list) or not numbers:
            raise self.refuse(key, numbers, f"numbers between {low:g} and {high:g}")
        parts = tuple(
            self.value(f"{key}[{k}]", v, "1", positive=False) for k, v in enumerate(numbers)
        )
        if list(parts) != sorted(set(parts)) or not low < parts[0] <= parts[-1] < high:
            raise self.refuse(key, numbers, f"increasing numbers between {low:g} and {high:g}")
        return parts

    def multiple(self, key: str, value: float, name: str, part: float, most: int) -> int:
        """Ratio of a key's value to a part, which must be a whole number of at most `most`."""
        ratio = value / part if part * most > value else math.inf
        if not (0.5 < ratio <= most and abs(ratio - round(ratio)) < 1e-6 * ratio):
            raise self.refuse(
                key, value, f"a whole multiple of the {name}, {part:g} s, at most {most} of them"
            )
        return round(ratio)


def opened(path: Path, kind: str, sections: Collection[str]) -> Table:
    """Read a TOML file and validate the names of its sections."""
    return Table(path, "", read_toml(path, kind)).known(sections)
