"""Assignment of columns to roles (time, current, speed, ...) and their units."""

import difflib
import math
import re
from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from gyrostat.core.errors import InputError
from gyrostat.core.units import SI_UNIT, Unit, find_unit, known_unit
from gyrostat.telemetry.fault import fault, listed, place, shown
from gyrostat.telemetry.record import CHANNELS, COLUMNS
from gyrostat.telemetry.role import Role

ROLES: dict[str, Role] = {
    **{name: role for name, role in COLUMNS.items() if role.required},
    # alternative to the speed
    "angle": Role("angle", ("angle", "position", "encoder"), "angle"),
    # added to the time: the fraction of a second in telemetry packets
    "time_fine": Role("time_fine", ("time_fine",), "time"),
    **{name: COLUMNS[name] for name in CHANNELS},
    "valid": Role("valid", ("valid",), None),
}
MOTION = ("speed", "angle")
"""Roles of which a record has one."""
_MAIN = ("current", *MOTION)
_NO_UNIT = Unit("")
_NO_UNIT_SPELLINGS = ("", "-", "1")


@dataclass(frozen=True)
class Column:
    """Column as described by the header of the file."""

    index: int
    names: tuple[str, ...]
    """Long and short name, or the only name."""
    unit: str = ""
    """Content of its cell in the row of units."""
    base: Hashable = None
    """What it shares with the columns that have the same times; None if the file does not say."""


@dataclass(frozen=True)
class Header:
    """Columns of a file, and the rows that describe them (None if the file has no rows)."""

    file: Path
    columns: tuple[Column, ...]
    row: int | None = None
    units_row: int | None = None


@dataclass(frozen=True)
class Chosen:
    """Column assigned to a role, and the unit of its numbers."""

    index: int
    name: str
    unit: Unit


def choose_columns(
    header: Header,
    columns: Mapping[str, str] | None,
    units: Mapping[str, str] | None,
    *,
    absent: Collection[str] = (),
    roles: Mapping[str, Role] = ROLES,
) -> dict[str, Chosen]:
    """Find the column and the unit of each role.

    Args:
        header: The columns of the file.
        columns: Role -> column name, for roles that are not found by their usual names.
        units: Role -> unit, which takes precedence over the header.
        absent: Roles that the file need not have, and that are not found by their names.
        roles: Name -> role, of the file's kind; by default those of a bench record.

    Returns:
        Role -> column, for the roles that the file provides.

    Raises:
        InputError: A column is missing, named twice or ambiguous; a unit is missing or unknown.
    """
    names = _by_role(header.file, "columns", columns, [*roles])
    stated = _by_role(
        header.file, "units", units, [k for k, role in roles.items() if role.dimension]
    )
    matches: dict[str, tuple[Column, str]] = {}
    for role, name in names.items():
        matches[role] = _column_named(header, roles[role], name)
    claimed = {column.index: role for role, (column, _) in matches.items()}
    if len(claimed) < len(matches):
        raise fault(header.file, "one column for two roles", "a column of its own for each role")
    unused = {*absent}
    if "angle" in roles:
        unused |= {*MOTION} - {_motion(header, matches, claimed)}
    # current and speed first: where a file has several time bases, the rest is that of theirs
    for role in sorted(roles.values(), key=lambda each: each.name not in _MAIN):
        if role.name not in matches and role.name not in unused:
            near = header if role.name in _MAIN else _at_times_of(header, matches)
            hit = _usual(near, role, claimed)
            if hit is not None:
                matches[role.name] = hit
    return {
        role: Chosen(column.index, name, _unit(header, roles[role], column, stated.get(role)))
        for role, (column, name) in ((each, matches[each]) for each in roles if each in matches)
    }


def _at_times_of(header: Header, matches: Mapping[str, tuple[Column, str]]) -> Header:
    """Header with the columns that have the times of the current, or of the speed without one."""
    bases = [matches[role][0].base for role in _MAIN if role in matches]
    if not bases or bases[0] is None:
        return header
    return replace(header, columns=tuple(c for c in header.columns if c.base in (bases[0], None)))


def _motion(
    header: Header, matches: Mapping[str, tuple[Column, str]], claimed: Mapping[int, str]
) -> str:
    """Role that the file measures, speed or angle: as named by the caller, otherwise the speed."""
    roles = [role for role in MOTION if role in matches]
    if len(roles) == 2:
        raise fault(header.file, "columns named for speed and for angle", "one of the two")
    if roles:
        return roles[0]
    speed = replace(ROLES["speed"], required=False)
    if _usual(header, speed, claimed) is None and _usual(header, ROLES["angle"], claimed):
        return "angle"
    return "speed"


def _by_role(
    file: Path, option: str, mapping: Mapping[str, str] | None, roles: Collection[str]
) -> dict[str, str]:
    """Mapping of the caller, with 'direction' replaced by 'setpoint'. Unknown roles are refused."""
    result: dict[str, str] = {}
    for key, value in (mapping or {}).items():
        role = "setpoint" if key == "direction" else key
        if role not in roles:
            expected = f"one of {', '.join(roles)}"
            raise fault(file, f"role {shown(key)} in {option}", expected)
        if role in result:
            raise fault(file, f"setpoint and direction in {option}", "one of the two")
        result[role] = value
    return result


def _split(name: str, dimension: str | None) -> tuple[str, str]:
    """Split a column name into name and unit: 'speed [rpm]', 'speed (rpm)', 'speed_rad_s'."""
    bracketed = re.fullmatch(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))\s*", name)
    if bracketed:
        return bracketed[1], (bracketed[2] or bracketed[3] or "").strip()
    if dimension is not None:
        for mark in re.finditer("_", name):
            suffix = name[mark.end() :]
            for spelling in (suffix.replace("_", "/"), suffix.replace("_", " ")):
                if known_unit(spelling, dimension):
                    return name[: mark.start()], spelling
    return name, ""


def _column_named(header: Header, role: Role, label: str) -> tuple[Column, str]:
    """Column named by the caller: exact match first, then ignoring case, then ignoring the unit."""
    dimension = role.dimension
    for key in (str, str.casefold, lambda name: _split(name, dimension)[0].casefold()):
        hits = [
            (column, name)
            for column in header.columns
            for name in column.names
            if key(name) == key(label)
        ]
        if hits:
            return _only(header, role.name, hits)
    raise _absent(header, f"a column {shown(label)} for {role.name}", label, dimension)


def _usual(header: Header, role: Role, claimed: Mapping[int, str]) -> tuple[Column, str] | None:
    """Column with a usual name of the role; None if an optional role has none."""
    free = [
        (column, name)
        for column in header.columns
        if column.index not in claimed
        for name in column.names
    ]
    hits = [hit for hit in free if _split(hit[1], role.dimension)[0].casefold() in role.names]
    if hits:
        return _only(header, role.name, hits)
    if not role.required:
        return None
    for _, name in free:
        base, _, suffix = name.partition("_")
        # A usual name followed by an unknown suffix: most likely a wrong unit.
        if role.dimension and suffix and len(base) > 1 and base.casefold() in role.names:
            find_unit(suffix, role.dimension, place(header.file, header.row, name))
    expected = f"one for {role.name}, called {' or '.join(role.names)}, or assigned in columns"
    raise _absent(header, expected, role.name, role.dimension)


def _absent(header: Header, expected: str, label: str, dimension: str | None) -> InputError:
    """Error for a missing column: lists the columns present and suggests the most similar one."""
    names = [name for column in header.columns for name in column.names]
    spellings = {_split(name, dimension)[0].casefold(): name for name in names}
    spellings |= {name.casefold(): name for name in names}
    near = difflib.get_close_matches(label.casefold(), spellings, n=1)
    hint = f"; did you mean {shown(spellings[near[0]])}?" if near else ""
    return fault(header.file, f"columns {listed(names)}", expected + hint, header.row)


def _only(header: Header, role: str, hits: list[tuple[Column, str]]) -> tuple[Column, str]:
    """Only column among the matches (its long and its short name may both match)."""
    if len({column.index for column, _ in hits}) == 1:
        return hits[0]
    names = [column.names[0] for column, _ in hits]
    if len(set(names)) == 1:
        raise fault(header.file, f"column {shown(names[0])} twice", f"one for {role}", header.row)
    expected = f"one for {role}, or an assignment in columns"
    raise fault(header.file, f"columns {listed(names)}", expected, header.row)


def _unit(header: Header, role: Role, column: Column, option: str | None) -> Unit:
    """Unit of a column: from the option, otherwise from the row of units and the column names."""
    if role.dimension is None:
        return _NO_UNIT
    in_names = [(_split(name, role.dimension)[1], header.row) for name in column.names]
    # If there is a row of units, a bracket may hold something else, as in 'velocity (left)'.
    if column.unit:
        in_names = [(text, row) for text, row in in_names if known_unit(text, role.dimension)]
    stated = [(column.unit, header.units_row), *in_names]
    if option is not None:
        counts = re.fullmatch(r"(rev|s)/(\d+)", option.strip())
        whole = {("rev", "angle"): 2.0 * math.pi, ("s", "time"): 1.0}
        if counts and int(counts[2]) > 0 and (counts[1], role.dimension) in whole:
            return Unit(option.strip(), whole[counts[1], role.dimension] / int(counts[2]))
        stated = [(option, None)]
    name = column.names[0]
    units: list[Unit] = []
    for text, row in stated:
        if role.unit_optional and text.strip() in _NO_UNIT_SPELLINGS:
            continue
        if text.strip():
            units.append(find_unit(text, role.dimension, place(header.file, row, name)))
    if not units and role.unit_optional:
        return _NO_UNIT
    if not units:
        example = f"{role.name} [{SI_UNIT[role.dimension]}]"
        expected = f"one in the header ({example!r}), in a row of units, or in units{role.hint}"
        raise fault(header.file, "no unit", expected, header.row, name)
    if any(unit != units[0] for unit in units):
        found = f"units {' and '.join(unit.symbol for unit in units)}"
        raise fault(header.file, found, "one unit", header.row, name)
    return units[0]
