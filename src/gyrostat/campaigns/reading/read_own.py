"""Read the names and the Python files of the user-defined parts of a scenario file."""

from collections.abc import Mapping

from gyrostat.campaigns.reading.tables import Table
from gyrostat.core.user_modules import Source, is_own, kind_from
from gyrostat.core.user_sources import sources_below


def own_kind(table: Table) -> str:
    """Kind of a user-defined part from the key `python` of a table, "FILE.py:NAME".

    Raises:
        InputError: The table also has a `kind`, or the text has another form.
    """
    found = table.text("python", None)
    if "kind" in table.row:
        raise table.refuse("kind", table.row["kind"], "none beside python")
    kind = kind_from(found)
    if kind is None:
        raise table.refuse("python", found, "FILE.py:NAME, such as 'mission.py:EarthPointer'")
    return kind


def own_sources(top: Table, kinds: Mapping[str, str]) -> tuple[Source, ...]:
    """Files that the user-defined parts of a scenario name, and the local modules that they import.

    Args:
        top: Top-level table of the scenario file.
        kinds: Place in the file -> kind.

    Raises:
        InputError: A file cannot be read, or is not below the folder of the scenario; or it imports
            a local module that is not.
    """
    named = {
        kind.partition(":")[0]: f"{top.path}: key {place}.python"
        for place, kind in kinds.items()
        if is_own(kind)
    }
    return sources_below(top.path.parent, named)
