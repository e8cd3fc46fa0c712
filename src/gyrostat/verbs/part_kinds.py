"""Parts that `export` knows, found in their folder."""

from collections.abc import Mapping
from typing import Any

from gyrostat.core.classes_of import classes_of
from gyrostat.verbs import parts as folder
from gyrostat.verbs.exported_part import ExportedPart

PARTS: Mapping[str, type[ExportedPart]] = {
    kind.name: kind for kind in sorted(classes_of(folder, ExportedPart), key=lambda k: k.name)
}
"""Name on the command line -> part."""


def part_kind(part: Any) -> str | None:
    """Key of a part in `PARTS`; None for anything else, such as a wheel."""
    return next((name for name, kind in PARTS.items() if kind.type() is type(part)), None)
