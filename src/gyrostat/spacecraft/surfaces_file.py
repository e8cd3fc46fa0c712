"""Read the surfaces of a spacecraft from its file: [box], [[panel]] and [[facet]].

[box]                             # six faces, edges along the body axes
size = ["20 cm", "10 cm", 0.3]    # m
centre = [0.0, 0.0, "15 cm"]      # m, body axes; optional, default the origin
specular = 0.1                    # share of the light reflected as by a mirror; optional, default 0
diffuse = 0.2                     # share of the light reflected diffusely; optional, default 0

[[panel]]                         # both sides; [[facet]] has the same keys and one side
name = "wing"
size = ["60 cm", "30 cm"]         # m; or area = "0.18 m²"
normal = [0.0, 0.0, 1.0]          # of any length; the outer side of a facet
centre = [0.0, "40 cm", 0.0]      # m, body axes
"""

from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import (
    described,
    direction,
    name_text,
    number,
    quantity,
    refuse_unknown,
    three,
)
from gyrostat.spacecraft.torques.surfaces import Surfaces

SURFACES = ("box", "panel", "facet")
"""Tables of a spacecraft file that describe its surfaces."""
_SHARES = ("specular", "diffuse")
_BOX = ("size", "centre", *_SHARES)
_FLAT = ("name", "area", "size", "normal", "centre", *_SHARES)
_KINDS = {"panel": Surfaces.panel, "facet": Surfaces.facet}


def read_surfaces(path: Path, table: dict[str, Any]) -> Surfaces | None:
    """Read the surfaces; None if the file has none.

    Args:
        path: Path of the file, for error messages.
        table: Content of the file.

    Raises:
        InputError: A key is unknown, missing or has an impossible value.
    """
    parts: list[Surfaces] = []
    if "box" in table:
        parts.append(_box(path, table["box"]))
    for kind, make in _KINDS.items():
        for name, row in named_tables(path, kind, table.get(kind, [])).items():
            prefix = f"{kind}[{name}]."
            refuse_unknown(path, prefix, row, _FLAT)
            shares = _shares(path, prefix, row)
            normal = direction(path, f"{prefix}normal", row.get("normal"))
            centre = three(path, f"{prefix}centre", row.get("centre"), "length")
            parts.append(make(_area(path, prefix, row), normal, centre, **shares))
    return Surfaces.joined(*parts) if parts else None


def named_tables(path: Path, kind: str, rows: object) -> dict[str, dict[str, Any]]:
    """Read tables of one kind: name -> table.

    Args:
        path: Path of the file, for the error message.
        kind: Name of the tables, such as "wheel".
        rows: Value from the file.

    Raises:
        InputError: It is not a list of tables; or a name is missing, is not allowed or occurs
            twice.
    """
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise InputError(f"{path}: key {kind}: found {described(rows)}, expected tables [[{kind}]]")
    tables: dict[str, dict[str, Any]] = {}
    for k, row in enumerate(rows):
        key = f"{kind}[{k}].name"
        name = name_text(path, key, row.get("name", ""))
        if not name or not set(name).isdisjoint("=, \t\n"):
            text = repr(name) if name else "none"
            raise InputError(
                f"{path}: key {key}: found {text}, expected a name without blanks, commas and "
                "equals signs"
            )
        if name in tables:
            raise InputError(f"{path}: key {key}: found {name!r} twice, expected it once")
        tables[name] = row
    return tables


def _box(path: Path, row: object) -> Surfaces:
    if not isinstance(row, dict):
        raise InputError(f"{path}: key box: found {described(row)}, expected a table [box]")
    refuse_unknown(path, "box.", row, _BOX)
    three(path, "box.size", row.get("size"), "length")
    size = [
        quantity(path, f"box.size[{k}]", edge, "length", positive=True)
        for k, edge in enumerate(row["size"])
    ]
    centre = three(path, "box.centre", row.get("centre", [0.0, 0.0, 0.0]), "length")
    return Surfaces.box(size, centre, **_shares(path, "box.", row))


def _area(path: Path, prefix: str, row: dict[str, Any]) -> float:
    """Area of a panel or facet, m², from its area or its two edges."""
    if ("area" in row) == ("size" in row):
        found = "both" if "area" in row else "none"
        raise InputError(
            f"{path}: key {prefix}area: found {found} of area and size, expected one of them"
        )
    if "area" in row:
        return quantity(path, f"{prefix}area", row["area"], "area", positive=True)
    edges = row["size"]
    if not isinstance(edges, list) or len(edges) != 2:
        raise InputError(
            f"{path}: key {prefix}size: found {described(edges)}, expected two lengths"
        )
    length, width = (
        quantity(path, f"{prefix}size[{k}]", edge, "length", positive=True)
        for k, edge in enumerate(edges)
    )
    return length * width


def _shares(path: Path, prefix: str, row: dict[str, Any]) -> dict[str, float]:
    """Reflected shares of the light."""
    shares = {
        name: number(path, f"{prefix}{name}", row.get(name, 0.0), positive=False)
        for name in _SHARES
    }
    for name, value in shares.items():
        if not 0.0 <= value <= 1.0:
            raise InputError(f"{path}: key {prefix}{name}: found {value:g}, expected 0 to 1")
    if sum(shares.values()) > 1.0:
        raise InputError(
            f"{path}: key {prefix}diffuse: found the sum {sum(shares.values()):g} with specular, "
            "expected at most 1"
        )
    return shares
