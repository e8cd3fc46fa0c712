"""Write a record so that `read_record` reads it back without loss."""

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.files import whole_file
from gyrostat.telemetry.fault import fault
from gyrostat.telemetry.record import COLUMNS, Record

_BLOCK = 10_000  # rows formatted at a time


def write_record(record: Record, path: str | os.PathLike[str]) -> None:
    """Write a record as CSV or Parquet; the suffix decides.

    The columns are time_s, current_A and speed_rad/s and, if the record has them, temperature_degC
    and setpoint (without a unit, because it may be a direction only). A missing speed sample is an
    empty cell. Numbers are read back bit for bit; name and notes are not written. The file appears
    under its name only when it is complete.

    Args:
        record: Record to write.
        path: File to write or replace, with the suffix .csv or .parquet.

    Raises:
        InputError: The suffix is not one of these, or the file cannot be written.
    """
    file = Path(path)
    writer = {".csv": _write_csv, ".parquet": _write_parquet}.get(file.suffix.lower())
    if writer is None:
        raise fault(file, f"the suffix {file.suffix!r}", "one of .csv, .parquet")
    series = {role.written: getattr(record, name) for name, role in COLUMNS.items()}
    columns = {name: values for name, values in series.items() if values is not None}
    with whole_file(file) as unfinished:
        writer(unfinished, columns)


def _write_csv(file: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    with file.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write(",".join(columns) + "\n")
        for start in range(0, columns["time_s"].size, _BLOCK):
            block = [series[start : start + _BLOCK].tolist() for series in columns.values()]
            stream.writelines(
                ",".join("" if number != number else repr(number) for number in row) + "\n"
                for row in zip(*block, strict=True)
            )


def _write_parquet(file: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    import pyarrow
    import pyarrow.parquet

    # from_pandas: NaN, which marks a missing sample, is stored as null.
    arrays = {name: pyarrow.array(series, from_pandas=True) for name, series in columns.items()}
    pyarrow.parquet.write_table(pyarrow.table(arrays), file)
