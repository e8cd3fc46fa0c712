"""Read the texts of [orbit] in a scenario file: epoch, elements, frame."""

from datetime import datetime

from gyrostat.core.toml_file import read_text
from gyrostat.scenario.scenario import Source
from gyrostat.scenario_files.tables import Table
from gyrostat.spacecraft.orbit.frames import FRAMES

LARGEST_FILE = 50_000_000
"""Largest size of a file with an orbit, bytes."""


def read_orbit(kind: str, table: Table) -> tuple[Source, ...]:
    """Texts of an orbit with their places in the scenario.

    Args:
        kind: Kind of the orbit.
        table: Table [orbit].

    Raises:
        InputError: A text is missing, a file cannot be read, or a frame is not known.
    """
    if kind == "none":
        return ()
    texts = {}
    if kind in ("tle", "file"):
        if "lines" in table.row and "file" in table.row:
            raise table.refuse("lines", table.row["lines"], "none beside file")
        if "lines" in table.row:
            texts["elements"] = table.text("lines", None)
        else:
            path = table.path.parent / table.text("file", None)
            texts["elements"] = read_text(path, "an orbit", LARGEST_FILE)
    if kind == "file":
        texts["frame"] = table.one_of("frame", FRAMES, "GCRS")
    if kind not in ("tle", "file") or "epoch" in table.row:
        texts["epoch"] = _epoch(table)
    return tuple(Source(f"orbit.{name}", text) for name, text in texts.items())


def _epoch(table: Table) -> str:
    """Epoch as text; TOML also has dates."""
    epoch = table.row.get("epoch")
    if isinstance(epoch, datetime):
        return epoch.isoformat()
    return table.text("epoch", None)
