"""Telemetry of `monitor` that stands in several logs, and the template of their columns."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gyrostat.monitoring import KnownWheels

JOINED = "telemetry.parquet"
TEMPLATE = "columns.toml"


@contextmanager
def joined_telemetry(
    files: Sequence[Path], columns: Any, known: "KnownWheels", out: Path | None, *, force: bool
) -> Iterator[tuple[Sequence[Path], Any]]:
    """Files and columns to monitor; logs are joined into telemetry.parquet in `out`.

    Args:
        files: Files of telemetry.
        columns: Role -> column, or a file of them, which may name logs.
        known: The wheels.
        out: Output folder; None: the joined telemetry is deleted afterwards.
        force: Whether a file of the user may be replaced.

    Raises:
        InputError: A file cannot be used, or a file of the user would be replaced.
    """
    import tempfile

    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.monitoring.logs import join_logs, read_logs_map

    logs = read_logs_map(Path(columns)) if isinstance(columns, str | Path) else []
    if not logs:
        yield files, columns
    elif out is None:
        with tempfile.TemporaryDirectory() as folder:
            join_logs(files, logs, known, Path(folder) / JOINED)
            yield [Path(folder) / JOINED], None
    else:
        check_outputs(out, (JOINED,), by="monitor", force=force)
        with new_files(out, by="monitor", force=force) as folder:
            join_logs(files, logs, known, folder / JOINED)
        yield [out / JOINED], None


def write_template(files: Sequence[Path], known: "KnownWheels", out: Path, *, force: bool) -> Path:
    """Write columns.toml to fill in; see `gyrostat.monitoring.logs_template`.

    Raises:
        InputError: A file cannot be read, or a file of the user would be replaced.
    """
    from gyrostat.core.outputs import new_files
    from gyrostat.monitoring.logs_template import columns_template

    text = columns_template(files, known)
    with new_files(out, by="monitor", force=force) as folder:
        (folder / TEMPLATE).write_text(text, encoding="utf-8")
    return out / TEMPLATE
