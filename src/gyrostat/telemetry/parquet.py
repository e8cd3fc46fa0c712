"""Read Parquet files."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Column, Header
from gyrostat.telemetry.fault import damaged, fault, too_many


def read_parquet(
    file: Path, choose: Callable[[Header], Mapping[str, Chosen]], max_samples: int
) -> Measured:
    """Read a Parquet file. A null counts as an empty cell.

    Args:
        file: A regular file.
        choose: Function from the header to role -> column.
        max_samples: Largest number of samples that is accepted.

    Returns:
        The chosen columns.

    Raises:
        InputError: Not a Parquet file, too many samples, or a column that does not contain numbers.
    """
    import pyarrow
    import pyarrow.parquet

    kinds = pyarrow.types
    try:
        with pyarrow.parquet.ParquetFile(file) as source:
            schema = source.schema_arrow
            columns = (Column(index, (name,)) for index, name in enumerate(schema.names))
            chosen = choose(Header(file, tuple(columns)))
            if source.metadata.num_rows > max_samples:
                raise too_many(file, max_samples)
            for column in chosen.values():
                kind = schema.field(column.index).type
                if not (kinds.is_integer(kind) or kinds.is_floating(kind) or kind == "bool"):
                    raise fault(file, f"values of type {kind}", "numbers", column=column.name)
            table = source.read(columns=[column.name for column in chosen.values()])
        cells = {role: table.column(column.name) for role, column in chosen.items()}
        floats = {role: cell.cast(pyarrow.float64(), safe=False) for role, cell in cells.items()}
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
