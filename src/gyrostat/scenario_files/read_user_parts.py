"""Read the names and the files of the user-defined parts of a scenario file."""

from collections.abc import Collection

from gyrostat.core.user_data import data_names, with_data
from gyrostat.core.user_modules import Source, kind_from
from gyrostat.core.user_sources import sources_below
from gyrostat.scenario_files.tables import Table

USER_KEYS = ("python", "data")
"""Keys of the table of a user-defined part that are none of its numbers."""


def user_kind(table: Table) -> str:
    """Kind of a user-defined part from the key `python` of a table, "FILE.py:NAME".

    Raises:
        InputError: The table also has a `kind`, or the text has another form.
    """
    text = table.text("python", None)
    if "kind" in table.row:
        raise table.refuse("kind", table.row["kind"], "none beside python")
    kind = kind_from(text)
    if kind is None:
        raise table.refuse("python", text, "FILE.py:NAME, such as 'mission.py:EarthPointer'")
    return kind


def user_sources(top: Table, tables: Collection[Table]) -> tuple[Source, ...]:
    """Files that the user-defined parts of a scenario name, and the local modules that they import.

    Args:
        top: Top-level table of the scenario file.
        tables: Tables of the user-defined parts.

    Raises:
        InputError: A file cannot be read, or is not below the folder of the scenario; or it imports
            a local module that is not.
    """
    kinds = {table.place("python"): user_kind(table) for table in tables}
    files = {kind.partition(":")[0]: place for place, kind in kinds.items()}
    sources, data = sources_below(top.path.parent, files), {}
    for table in tables:
        if "data" in table.row:
            data |= data_names(table.place("data"), table.row["data"])
    return with_data(top.path.parent, sources, kinds.values(), data)
