"""Parquet files."""

from pathlib import Path
from typing import ClassVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Column, Header
from gyrostat.telemetry.fault import damaged, fault, too_many
from gyrostat.telemetry.record_format import RecordFormat, Request


class Parquet(RecordFormat):
    """Columns of a table. A null counts as an empty cell."""

    suffixes: ClassVar[tuple[str, ...]] = (".parquet",)

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        import pyarrow
        import pyarrow.parquet

        kinds = pyarrow.types
        try:
            with pyarrow.parquet.ParquetFile(file) as source:
                schema = source.schema_arrow
                columns = (Column(index, (name,)) for index, name in enumerate(schema.names))
                chosen = request.choose(Header(file, tuple(columns)))
                if source.metadata.num_rows > request.max_samples:
                    raise too_many(file, request.max_samples)
                for column in chosen.values():
                    kind = schema.field(column.index).type
                    if not (kinds.is_integer(kind) or kinds.is_floating(kind) or kind == "bool"):
                        raise fault(file, f"values of type {kind}", "numbers", column=column.name)
                table = source.read(columns=[column.name for column in chosen.values()])
            cells = {role: table.column(column.name) for role, column in chosen.items()}
            floats = {
                role: cell.cast(pyarrow.float64(), safe=False) for role, cell in cells.items()
            }
            return Measured(
                file,
                chosen,
                values={role: cell.to_numpy() for role, cell in floats.items()},
                empty={role: cell.is_null().to_numpy() for role, cell in floats.items()},
                rows=np.arange(1, table.num_rows + 1),
            )
        except InputError:
            raise
        except Exception as error:  # a damaged file makes the library raise errors of many classes
            raise damaged(file, "a Parquet file", error) from None
