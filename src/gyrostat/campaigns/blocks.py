"""Blocks of runs as Parquet files, with a digest in the file name.

000012.<SHA-256 digest of campaign, block number and content>.parquet
"""

import hashlib
import io
import re
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.campaigns.description import Campaign

if TYPE_CHECKING:
    from pathlib import Path

    import pyarrow.parquet as pq

    from gyrostat.core.types import Matrix, Vector

_NAME = re.compile(r"(\d{6,})\.[0-9a-f]{64}\.parquet")


def packed(campaign: Campaign, number: int, columns: Mapping[str, "Vector"]) -> tuple[str, bytes]:
    """File name and content of a block.

    Args:
        campaign: Campaign of the block.
        number: Number of the block.
        columns: Columns of the table, name -> (runs,), or (runs, numbers) for a list for each run,
            which is null if all of its numbers are NaN.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    runs = columns["run"]
    metadata = {
        "campaign": campaign.identity,
        "seed": str(campaign.seed),
        "runs": f"{runs[0]} to {runs[-1]}",
    }
    buffer = io.BytesIO()
    table = pa.table({name: _column(values) for name, values in columns.items()})
    pq.write_table(table.replace_schema_metadata(metadata), buffer)
    content = buffer.getvalue()
    return name_of(campaign, number, content), content


def _column(values: Any) -> Any:
    """Column of a table, from numbers; of a two-dimensional array, one of lists."""
    import pyarrow as pa

    if values.ndim == 1:
        assert values.dtype != bool, "a table has bits for them, an array bytes"
        # `pa.array` of an array imports pandas, which takes 0.2 s
        numbers = pa.py_buffer(np.ascontiguousarray(values))
        return pa.Array.from_buffers(
            pa.from_numpy_dtype(values.dtype), len(values), [None, numbers], null_count=0
        )
    missing = np.all(np.isnan(values), axis=1)
    rows = [None if none else row for none, row in zip(missing, values, strict=True)]
    return pa.array(rows, pa.list_(pa.from_numpy_dtype(values.dtype)))


def scalar_columns(file: "pq.ParquetFile") -> list[str]:
    """Names of the columns of a table that have one number for each run."""
    import pyarrow as pa

    return [field.name for field in file.schema_arrow if not pa.types.is_list(field.type)]


def list_parts(file: "pq.ParquetFile", name: str, runs: int) -> "Iterator[Matrix]":
    """Read a column with several numbers for each run, part by part.

    Args:
        file: Table.
        name: Name of the column; there is nothing to read if the table has none.
        runs: Number of runs to read, from the first.

    Yields:
        Numbers of the runs that have some, (runs, numbers).
    """
    if name not in file.schema_arrow.names:
        return
    for part in file.iter_batches(batch_size=4096, columns=[name]):
        rows: Any = part.column(0)[:runs]
        count = len(rows) - rows.null_count
        if count:
            yield array_of(rows.flatten()).reshape(count, -1).astype(np.float64)
        runs -= len(rows)
        if runs <= 0:
            return


def name_of(campaign: Campaign, number: int, content: bytes) -> str:
    """File name of a block of a campaign with this number and content."""
    digest = hashlib.sha256(f"{campaign.identity} {number} ".encode() + content).hexdigest()
    return f"{number:06d}.{digest}.parquet"


def number_of(name: str) -> int | None:
    """Number of a block from its file name; None if it is not the name of a block."""
    match = _NAME.fullmatch(name)
    return None if match is None else int(match[1])


def table_at(path: "Path") -> Any:
    """Table of a file; `pyarrow.parquet.read_table` imports pandas."""
    import pyarrow.parquet as pq

    with pq.ParquetFile(path) as file:
        return file.read()


def columns_of(table: Any) -> dict[str, Any]:
    """Columns of a table of runs as arrays: name -> (runs,)."""
    return {name: array_of(table[name].combine_chunks()) for name in table.column_names}


def array_of(column: Any) -> Any:
    """Arrow array as a NumPy array, without `to_numpy`, which would import pandas (0.2 s)."""
    return np.array(np.from_dlpack(column))
