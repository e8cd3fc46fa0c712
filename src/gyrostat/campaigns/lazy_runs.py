"""Columns of a large table of runs as arrays of xarray, read when their values are used."""

from typing import Any, final

import numpy as np
from xarray.backends import BackendArray
from xarray.core import indexing

from gyrostat.campaigns.run_table import RunTable


@final
class _Column(BackendArray):
    """Column of a table of runs.

    Args:
        table: Table.
        name: Name of the column.
        dtype: Type of its numbers.
    """

    def __init__(self, table: RunTable, name: str, dtype: np.dtype):
        self._table, self._name = table, name
        self.shape = (table.runs,)
        self.dtype = dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Values at some runs."""
        read = self._values
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, read
        )

    def _values(self, key: tuple[Any, ...]) -> Any:
        return np.asarray(self._table.read(self._name)[key[0]])


def lazy_column(table: RunTable, name: str) -> Any:
    """Data of a variable of xarray; nothing stays in memory when they have been used."""
    return indexing.LazilyIndexedArray(_Column(table, name, table.dtype(name)))
