"""Read the lists of parts of a scenario file: [[environment.torque]], [[sensor]], [[actuator]]."""

import itertools
import keyword
import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from gyrostat.core.errors import InputError, placed
from gyrostat.core.user_modules import is_user_kind
from gyrostat.scenario.kinds.registry import PARTS, component
from gyrostat.scenario.metrics.kinds import RUN_METRICS
from gyrostat.scenario.mode_kind import Mode
from gyrostat.scenario.reference_kind import AROUND
from gyrostat.scenario.scenario import WINDOWS, Part, Source
from gyrostat.scenario.timeline import END_OF_MODE, TRANSITION
from gyrostat.scenario.transition_kind import Transition
from gyrostat.scenario.user.kinds import USER_KINDS
from gyrostat.scenario_files.read_user_parts import USER_KEYS, user_kind
from gyrostat.scenario_files.tables import Table
from gyrostat.spacecraft import SpacecraftMeasurement, TrackerGyroMeasurement

LINKS = {
    "reference.mode": Mode.links,
    TRANSITION: Transition.links,
    "reference.slew": PARTS["reference.slew"]["slew"].links,
    "metric": PARTS["metric"]["jitter"].links,
}
"""Section -> key of a part that names other parts -> their section."""
LISTS = ("from", AROUND, "window")
"""Keys that may name several parts."""
_MEASURED = (*TrackerGyroMeasurement._fields, *SpacecraftMeasurement._fields, "time")
TAKEN = {
    "sensor": (tuple(dict.fromkeys(_MEASURED)), ("attitude_", "wheel_")),
    "actuator": (("torque", "external_torque"), ()),
    "metric": (
        ("run", "status", "ended", *(name for kind in RUN_METRICS for name in kind.columns)),
        (),
    ),
    "station": (("eclipse", "sunlight"), ()),
    TRANSITION: ((), (END_OF_MODE,)),
}
"""Section -> names of fields that exist already, and beginnings of names that belong to others."""


def read_parts(top: Table) -> list[tuple[Part, Table]]:
    """Read the names and kinds of the parts of all lists.

    Args:
        top: Top-level table of the file.

    Returns:
        Each part with its table, in the order of the file.

    Raises:
        InputError: A kind or a name is not allowed, or two parts of a list have the same name.
    """
    parts: list[tuple[Part, Table]] = []
    for section in PARTS:
        for row in _tables(top, section):
            part = _part(section, row, [p.name for p, _ in parts if p.section == section])
            parts.append((part, Table(top.path, f"{section}[{part.name}].", row.row)))
    windows = [
        (Part(WINDOWS, row.row.get("name", str(number + 1)), ""), row)
        for number, row in enumerate(_tables(top, WINDOWS))
    ]
    named = [*parts, *windows]
    return [(replace(part, links=tuple(_links(part, row, named))), row) for part, row in parts]


def _links(
    part: Part, row: Table, parts: Collection[tuple[Part, Table]]
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Keys of a part that name other parts, with those names; see `Part.links`.

    Raises:
        InputError: There is no such part.
    """
    # a user's metric may have a number of the same name
    links = {} if is_user_kind(part.kind) and part.section == "metric" else LINKS
    for key, section in links.get(part.section, {}).items():
        names = [other.name for other, _ in parts if other.section == section]
        value = row.row.get(key)
        if value is None and key != "to":
            continue
        found = tuple(value) if isinstance(value, list) else (value,)
        is_one = len(found) == 1 or (key in LISTS and found)
        if not is_one or any(name not in names for name in found):
            expected = f"one of {', '.join(names)}" if names else f"a [[{section}]] with this name"
            raise row.refuse(key, value, expected)
        yield key, tuple(map(str, found))


def completed(table: Table, kind: Any, values: Mapping[str, float]) -> Table:
    """Table of a component with what follows from other sections.

    Args:
        table: Table of the component.
        kind: Its kind.
        values: Full key -> value of the sections read before.
    """
    with placed(f"{table.path}: key {table.prefix.rstrip('.')}"):
        return Table(table.path, table.prefix, kind.row(table.row, values))


def part_values(
    parts: Collection[tuple[Part, Table]],
    before: Mapping[str, float],
    sources: tuple[Source, ...],
    delay: int,
) -> dict[str, float]:
    """Read the numbers of all parts: full keys -> values, SI.

    Args:
        parts: Parts with their tables.
        before: Full key -> value of the sections read before.
        sources: Python files of the scenario.
        delay: Command delay, periods.

    Raises:
        InputError: A key is unknown, missing or has a value that is not allowed.
    """
    values: dict[str, float] = {}
    for part, row in parts:
        component_kind = component(part.section, part.kind, sources)
        extra = USER_KEYS if "python" in row.row and part.section in USER_KINDS else ()
        texts = (*component_kind.texts, *component_kind.links)
        row.known(("name", "kind", *extra, *component_kind.keys(), *texts))
        prefix = f"{part.section}.{part.name}."
        known = {**before, **values}
        table = completed(row, component_kind, known)
        table = table.with_missing(component_kind.defaults(known, delay))
        values |= table.numbers(component_kind.keys(), prefix)
    return values


def user_tables(top: Table) -> Iterator[Table]:
    """Table of each user-defined part of a list and of each user-defined event."""
    for section in (section for section in (*PARTS, "event") if section in USER_KINDS):
        for row in _tables(top, section):
            if "python" in row.row:
                yield row


def _tables(top: Table, section: str) -> list[Table]:
    if section == "sensor" and isinstance(top.row.get("sensor"), dict):
        raise InputError(
            f"{top.place('sensor')}: found a table [sensor], expected [sensors], or tables "
            "[[sensor]] for further sensors"
        )
    outer, _, inner = section.rpartition(".")
    return (top.table(outer, None) if outer else top).tables(inner)


def _part(section: str, row: Table, names: Collection[str]) -> Part:
    kinds = PARTS[section]
    if "python" in row.row and section in USER_KINDS:
        kind = user_kind(row)
    elif section == "metric" and "kind" not in row.row:
        raise InputError(
            f"{row.place('python')}: found keys {', '.join(sorted(row.row)) or 'none'}, expected "
            f'python = "FILE.py:NAME" or kind = "{next(iter(kinds))}"'
        )
    else:
        has_default = len(kinds) == 1 or section == TRANSITION
        kind = row.one_of("kind", kinds, next(iter(kinds)) if has_default else None)
    return Part(section, part_name(section, row, kind, names), kind)


def part_name(section: str, row: Table, kind: str, others: Collection[str]) -> str:
    """Name of a part; by default its kind, or its class in lower case with underscores.

    Args:
        section: Section of the part.
        row: Its table.
        kind: Its kind.
        others: Names of the other parts of the section.

    Raises:
        InputError: The name is not allowed, or exists already.
    """
    short = kind.rpartition(":")[2]
    default = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", short).lower()
    if section == TRANSITION:
        default = _numbered(f"to_{row.row.get('to')}", others)
    name = row.text("name", default)
    plain = name.isascii() and name.isidentifier() and not name.startswith("_")
    if not plain or keyword.iskeyword(name):
        raise row.refuse(
            "name", name, "letters, digits and underscores, a letter first, and no Python keyword"
        )
    if name in others:
        raise row.refuse("name", name, f"another name than that of another [[{section}]]")
    fields, beginnings = TAKEN.get(section, ((), ()))
    if name in fields:
        raise row.refuse("name", name, f"none of {', '.join(fields)}, which exist already")
    for beginning in beginnings:
        if name.startswith(beginning):
            expected = f"a name that does not begin with {beginning}, as built-in names do"
            raise row.refuse("name", name, expected)
    return name


def _numbered(name: str, others: Collection[str]) -> str:
    """Name with a number if another part has it already."""
    names = itertools.chain([name], (f"{name}_{k}" for k in itertools.count(2)))
    return next(each for each in names if each not in others)
