"""Read [reference], [[reference.mode]] and [[reference.slew]] of a scenario file."""

from collections.abc import Mapping, Sequence
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text
from gyrostat.scenario.kinds.registry import PARTS
from gyrostat.scenario.reference_kind import ERROR, POSITION_ERROR
from gyrostat.scenario.scenario import Part, Source
from gyrostat.scenario_files.tables import Table

LARGEST_TABLE = 10_000_000
"""Largest size of the file of a reference, bytes."""


def position_error(table: Table, kind: Any, orbit: str) -> dict[str, float]:
    """Values of the position error of the reference; none if it is not given.

    Args:
        table: Table [reference].
        kind: Kind of the reference, a component.
        orbit: Kind of [orbit].

    Raises:
        InputError: It is no vector of lengths, or nothing depends on it.
    """
    if "position_error" not in table.row:
        return {}
    value = table.row["position_error"]
    if orbit == "none" or not kind.moves:
        raise table.refuse("position_error", value, "none without [orbit] and a moving reference")
    return table.number("position_error", ERROR, value, POSITION_ERROR)


def check_reference(
    kind: Any, parts: Sequence[tuple[Part, Table]], top: Table, values: Mapping[str, float]
) -> None:
    """Check targets and times of a reference, and that the controller has no target beside it.

    Args:
        kind: Kind of the reference, a component.
        parts: Parts of all lists with their tables.
        top: Top-level table of the file.
        values: Full key -> value.

    Raises:
        InputError: A target is no quaternion or is given twice.
    """
    controller = top.table("controller", None)
    if kind.moves and "target" in controller.row:
        raise InputError(
            f"{controller.place('target')}: found a target attitude beside the reference "
            f"{kind.name}, expected none: the reference is the target"
        )
    for part, row in parts:
        if "target" in row.row and part.section in ("reference.mode", "reference.slew"):
            row.unit("target", 4, None)


def read_tables(
    kind: Any, parts: Sequence[tuple[Part, Table]], top: Table, duration: float
) -> tuple[Source, ...]:
    """Read the files of a reference and of its modes.

    Args:
        kind: Kind of the reference, a component.
        parts: Parts of all lists with their tables.
        top: Top-level table of the file.
        duration: Duration of the run, s.

    Raises:
        InputError: A file cannot be read, or is not what its kind needs; or the file of a
            reference of one mode does not cover the run.
    """
    rows = {
        f"{part.section}.{part.name}": (PARTS[part.section][part.kind].attitude, row)
        for part, row in parts
        if part.section == "reference.mode"
        and part.kind in PARTS[part.section]
        and PARTS[part.section][part.kind].texts
    }
    if kind.texts:
        rows["reference"] = kind, top.table("reference", None)
    sources = []
    for name, (profile, row) in rows.items():
        path = row.path.parent / row.text("file", None)
        text = read_text(path, "the file of a reference", LARGEST_TABLE)
        content = profile.read_file(str(path), text)
        if name == "reference":
            profile.check_cover(content, str(path), duration)
        sources.append(Source(name, text))
    return tuple(sources)
