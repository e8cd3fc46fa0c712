"""Read the files of [[metric]]: wheels on a structure."""

from collections.abc import Iterable

from gyrostat.core.user_modules import is_user_kind
from gyrostat.scenario.scenario import Part, Source
from gyrostat.scenario_files.tables import Table


def read_structures(parts: Iterable[tuple[Part, Table]]) -> list[Source]:
    """Content of the file of each metric that has one, by the place of the metric.

    Args:
        parts: Parts of all lists with their tables.

    Raises:
        InputError: A file, or one that it names, cannot be read or used.
    """
    rows = {
        part.name: row
        for part, row in parts
        if part.section == "metric" and not is_user_kind(part.kind)
    }
    if not rows:
        return []
    # they import SciPy, which takes long
    from gyrostat.microvibration.disturbance_file import read_structure
    from gyrostat.microvibration.structure_text import structure_text

    return [
        Source(
            f"metric.{name}",
            structure_text(read_structure(row.path.parent / row.text("file", None))),
        )
        for name, row in rows.items()
    ]
