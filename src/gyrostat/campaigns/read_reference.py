"""Read [reference], [[reference.mode]] and [[reference.slew]] of a scenario file."""

from collections.abc import Mapping, Sequence

from gyrostat.campaigns.environments import ORBIT
from gyrostat.campaigns.read_events import within_run
from gyrostat.campaigns.references import LIMITS, LISTS, attitude_table
from gyrostat.campaigns.scenario import Event, Part, Source
from gyrostat.campaigns.tables import Table
from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text

LARGEST_TABLE = 10_000_000
"""Largest size of an attitude table, bytes."""


def with_defaults(table: Table, kind: str, values: Mapping[str, float]) -> Table:
    """Table of a reference or mode whose missing numbers are given elsewhere in the scenario.

    Args:
        table: Table [reference] or [[reference.mode]].
        kind: Kind of the reference or mode.
        values: Full key -> value of the sections read before.
    """
    row = {k: v for k, v in table.row.items() if k not in LIMITS or v != "auto"}
    if kind == "nadir":
        orbit = {name: f"environment.{name}" for name in ORBIT}
        row = {n: values[key] for n, key in orbit.items() if key in values} | row
    return Table(table.path, table.prefix, row)


def check_reference(
    kind: str,
    parts: Sequence[tuple[Part, Table]],
    top: Table,
    events: Sequence[Event],
    values: Mapping[str, float],
) -> None:
    """Check that a reference has the lists that it needs and no other, and no second target.

    Args:
        kind: Kind of the reference.
        parts: Parts of all lists with their tables.
        top: Top-level table of the file.
        events: Events of the scenario.
        values: Full key -> value.

    Raises:
        InputError: A list is missing or unused, a target is given twice, a target is no quaternion,
            or the slews are not in the order of their times.
    """
    table = top.table("reference", None)
    mine = {name: [t for p, t in parts if p.section == name] for name in LISTS.values()}
    for owner, name in LISTS.items():
        if kind == owner and not mine[name]:
            raise InputError(f"{table.place('kind')}: found {kind}, expected tables [[{name}]]")
        if kind != owner and mine[name]:
            raise InputError(
                f"{top.path}: key {name}: found tables with the reference {kind}, expected none: "
                f"only the reference {owner} has them"
            )
    for rows in mine.values():
        for row in rows:
            if "target" in row.row:
                row.unit("target", 4, None)
    if kind == "fixed":
        return
    controller = top.table("controller", None)
    slew = next((f"event[{event.name}]" for event in events if event.kind == "slew"), None)
    if "target" in controller.row or slew is not None:
        place = controller.place("target") if slew is None else f"{top.path}: key {slew}"
        raise InputError(
            f"{place}: found a target attitude beside the reference {kind}, expected none: the "
            "reference is the target"
        )
    last = -1.0
    for part, row in parts:
        if part.section == "reference.slew":
            time = values[f"{part.section}.{part.name}.time"]
            within_run(row, "time", time, dict(values))
            if time <= last:
                raise row.refuse("time", time, f"a time after the slew before, {last:g} s")
            last = time


def read_tables(kind: str, parts: Sequence[tuple[Part, Table]], top: Table) -> tuple[Source, ...]:
    """Read the attitude tables of a reference.

    Args:
        kind: Kind of the reference.
        parts: Parts of all lists with their tables.
        top: Top-level table of the file.

    Raises:
        InputError: A file cannot be read, or is not a table of attitudes.
    """
    rows = {
        f"{part.section}.{part.name}": row
        for part, row in parts
        if (part.section, part.kind) == ("reference.mode", "table")
    }
    if kind == "table":
        rows["reference"] = top.table("reference", None)
    found = []
    for place, row in rows.items():
        path = row.path.parent / row.text("file", None)
        text = read_text(path, "an attitude table", LARGEST_TABLE)
        attitude_table(str(path), text)
        found.append(Source(place, text))
    return tuple(found)
