"""Parquet files."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Column, Header
from gyrostat.telemetry.fault import damaged, fault, too_many
from gyrostat.telemetry.record_format import RecordFormat, Request


class Parquet(RecordFormat):
    """Columns of a table. A null counts as an empty cell."""

    suffixes: ClassVar[tuple[str, ...]] = (".parquet",)
    in_parts: ClassVar[bool] = True

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        with _opened(file) as source:
            chosen = _chosen(file, source, request)
            if source.metadata.num_rows > request.max_samples:
                raise too_many(file, request.max_samples)
            table = source.read(columns=[column.name for column in chosen.values()])
            return _measured(file, chosen, table, 1)

    @classmethod
    def parts(cls, file: Path, request: Request) -> Iterator[Measured]:
        """See `RecordFormat.parts`."""
        with _opened(file) as source:
            chosen = _chosen(file, source, request)
            names = [column.name for column in chosen.values()]
            row = 1
            for batch in source.iter_batches(request.max_samples, columns=names):
                yield _measured(file, chosen, batch, row)
                row += batch.num_rows


@contextmanager
def _opened(file: Path) -> Iterator[Any]:
    """Open a Parquet file; errors of the library become errors of the file."""
    import pyarrow.parquet

    try:
        with pyarrow.parquet.ParquetFile(file) as source:
            yield source
    except InputError:
        raise
    except Exception as error:  # a damaged file makes the library raise errors of many classes
        raise damaged(file, "a Parquet file", error) from None


def _chosen(file: Path, source: Any, request: Request) -> Mapping[str, Chosen]:
    """Chosen columns of an open file; they must hold numbers."""
    import pyarrow

    kinds, schema = pyarrow.types, source.schema_arrow
    columns = (Column(index, (name,)) for index, name in enumerate(schema.names))
    chosen = request.choose(Header(file, tuple(columns)))
    for column in chosen.values():
        kind = schema.field(column.index).type
        if not (kinds.is_integer(kind) or kinds.is_floating(kind) or kind == "bool"):
            raise fault(file, f"values of type {kind}", "numbers", column=column.name)
    return chosen


def _measured(file: Path, chosen: Mapping[str, Chosen], table: Any, row: int) -> Measured:
    """Columns of a table or batch, whose first row has the given number."""
    import pyarrow

    cells = {role: table.column(column.name) for role, column in chosen.items()}
    floats = {role: cell.cast(pyarrow.float64(), safe=False) for role, cell in cells.items()}
    return Measured(
        file,
        chosen,
        values={role: np.asarray(cell) for role, cell in floats.items()},
        empty={role: np.asarray(cell.is_null()) for role, cell in floats.items()},
        rows=np.arange(row, row + table.num_rows),
    )
