"""Table of the runs of a campaign, of which one column at a time is in memory."""

from collections import OrderedDict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from gyrostat.campaigns.blocks import array_of, scalar_columns

LARGE: Final = 20_000_000
"""Number of numbers above which a table is large, 160 MB."""
KEPT: Final = 48_000_000
"""Size of the columns that stay in memory, bytes."""


class Columns(Sequence[Any]):
    """Columns of a table of runs, each read when it is asked for.

    Args:
        table: Table.
        names: Names of the columns.
    """

    def __init__(self, table: Mapping[str, Any], names: tuple[str, ...]):
        self._table, self._names = table, names

    def __getitem__(self, index: Any) -> Any:
        """Column, (runs,)."""
        return self._table[self._names[index]]

    def __len__(self) -> int:
        """Number of columns."""
        return len(self._names)


class RunTable(Mapping[str, Any]):
    """Columns with one number for each run, by name, (runs,); each is read when it is asked for.

    A table of up to 200 000 runs with 30 columns stays in memory; of a larger one, the columns that
    were asked for last.

    Args:
        path: Parquet file.
    """

    def __init__(self, path: Path):
        import pyarrow.parquet as pq

        self._file = pq.ParquetFile(path)
        self._names = scalar_columns(self._file)
        self._columns: OrderedDict[str, Any] = OrderedDict()
        metadata = self._file.metadata
        sizes = [metadata.row_group(k).num_rows for k in range(metadata.num_row_groups)]
        self._starts = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)
        self.runs = int(metadata.num_rows)

    def __getitem__(self, name: str) -> Any:
        """Column, read-only."""
        if name in self._columns:
            self._columns.move_to_end(name)
            return self._columns[name]
        column = self.read(name)
        column.flags.writeable = False
        self._columns[name] = column
        while sum(each.nbytes for each in self._columns.values()) > KEPT:
            self._columns.popitem(last=False)
        return column

    def __iter__(self) -> Iterator[str]:
        """Names of the columns."""
        return iter(self._names)

    def __len__(self) -> int:
        """Number of columns."""
        return len(self._names)

    def of(self, names: Iterable[str]) -> "Columns":
        """Some columns, in this order."""
        return Columns(self, tuple(names))

    def read(self, name: str) -> Any:
        """Column as a new array."""
        if name not in self._names:
            raise KeyError(name)
        return self._read(name, self.runs)

    def head(self, count: int) -> dict[str, Any]:
        """Columns of the first runs.

        Args:
            count: Largest number of runs.
        """
        if self.runs <= count:
            return {name: self[name] for name in self}
        return {name: self._read(name, count) for name in self}

    def row(self, run: int) -> dict[str, Any]:
        """Values of a run, by name; None where the table has none.

        Args:
            run: Number of the run.
        """
        group = int(np.searchsorted(self._starts, run, side="right")) - 1
        part = self._file.read_row_group(group, columns=self._names)
        place = run - int(self._starts[group])
        return {name: part[name][place].as_py() for name in self._names}

    @property
    def is_large(self) -> bool:
        """Whether the table has more than `LARGE` numbers."""
        return self.runs * len(self) > LARGE

    def dtype(self, name: str) -> np.dtype:
        """Type of the numbers of a column."""
        return np.dtype(self._file.schema_arrow.field(name).type.to_pandas_dtype())

    def _read(self, name: str, count: int) -> Any:
        """First values of a column, group by group: two copies of it would not fit in memory."""
        column: Any = None
        for group, (first, last) in enumerate(zip(self._starts, self._starts[1:], strict=False)):
            if first >= count:
                break
            part = self._file.read_row_group(group, columns=[name], use_threads=False)
            values = array_of(part[name].combine_chunks())
            if column is None:
                column = np.empty(count, values.dtype)
            column[first:last] = values[: count - first]
        return np.zeros(0) if column is None else column
