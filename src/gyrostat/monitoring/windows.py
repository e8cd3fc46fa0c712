"""Window table: estimates and statistics of each wheel in each window of time, by default a day.

The table is all that trends, change points and alarms use. Its file is Parquet; the unit of each
column is in the metadata of its field.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.files import whole_file

PARAMETERS = {
    "coulomb": "N·m",
    "viscous": "N·m·s/rad",
    "motor_constant": "N·m/A",
    "offset": "N·m",
    "static": "N·m",
}
"""Parameter -> unit. `coulomb` is the mean of the realised Coulomb torque over the window."""

REGRESSED = ("coulomb", "viscous", "motor_constant", "offset")
"""Parameters whose covariances are in the table."""


@dataclass(frozen=True)
class Column:
    """Column of the window table.

    Attributes:
        kind: Type of its values: "number" (NaN: unknown), "count", "flag" or "text".
        unit: SI unit, empty if it has none.
        meaning: What the column is.
    """

    kind: str
    unit: str
    meaning: str


def _parameter_columns() -> dict[str, Column]:
    columns: dict[str, Column] = {}
    for name, unit in PARAMETERS.items():
        columns[name] = Column("number", unit, f"estimate of {name}")
        columns[f"{name}_sigma"] = Column("number", unit, "its standard deviation")
        columns[f"{name}_scatter"] = Column(
            "number", unit, "part of its standard deviation that differs from window to window"
        )
        columns[f"{name}_observable"] = Column("flag", "", "whether the window determines it")
        columns[f"{name}_reason"] = Column("text", "", "why it is not observable; empty if it is")
    for name in REGRESSED[1:]:
        columns[f"{name}_known"] = Column(
            "number", PARAMETERS[name], "standard deviation of what was known beforehand, as used"
        )
    for first, second in combinations(REGRESSED, 2):
        columns[f"cov_{first}_{second}"] = Column(
            "number", f"{PARAMETERS[first]}·{PARAMETERS[second]}", "covariance of the estimates"
        )
    return columns


COLUMNS: dict[str, Column] = {
    "wheel": Column("text", "", "name of the wheel"),
    "start": Column("number", "s", "start of the window, on the clock of the telemetry"),
    "end": Column("number", "s", "end of the window"),
    "samples": Column("count", "", "samples used"),
    **_parameter_columns(),
    "coulomb_level": Column("number", "N·m", "long-run level of the Coulomb torque"),
    "coulomb_level_sigma": Column("number", "N·m", "its standard deviation"),
    "noise_sigma": Column("number", "N·m", "standard deviation of the slow friction noise"),
    "noise_time": Column("number", "s", "correlation time of the slow friction noise"),
    "speed_mean": Column("number", "rad/s", "mean speed"),
    "speed_min": Column("number", "rad/s", "lowest mean speed of a block"),
    "speed_max": Column("number", "rad/s", "highest mean speed of a block"),
    "temperature_mean": Column("number", "°C", "mean temperature"),
    "temperature_min": Column("number", "°C", "lowest mean temperature of a block"),
    "temperature_max": Column("number", "°C", "highest mean temperature of a block"),
    "stuck_blocks": Column("count", "", "blocks left out, as a sensor of speed or drive is stuck"),
    "held_as_stated": Column(
        "text", "", "parameters that hold as stated, as the rounding of the drive leaves them open"
    ),
    "crossings": Column("count", "", "changes of the sign of the speed"),
    "gap_share": Column("number", "", "share of the window without usable telemetry"),
    "residual_rms": Column("number", "N·m", "robust rms of the fast residual of a block"),
    "residual_kurtosis": Column("number", "", "excess kurtosis of the fast residual"),
    "residual_excess": Column(
        "number", "", "largest residual over 10 minutes above the median, over its robust sigma"
    ),
    "residual_lowest": Column(
        "number", "", "smallest residual over 10 minutes below the median, over its robust sigma"
    ),
    "crossing_residual": Column(
        "number", "N·m", "mean friction torque beyond the estimate in blocks at low speed"
    ),
    "exchange_residual": Column(
        "number", "N·m", "rms of the torque that wheels and body do not exchange, along the axis"
    ),
    "speed_scale": Column(
        "number", "", "true over measured speed, from the momentum that wheels and body exchange"
    ),
    "speed_scale_sigma": Column("number", "", "its standard deviation"),
    "standstill_share": Column("number", "", "share of samples with the wheel at rest, not off"),
    "standstill_torque": Column("number", "N·m", "largest motor torque at rest"),
    "valid": Column("flag", "", "whether the estimates hold"),
    "why": Column("text", "", "why they do not; empty if they do"),
}
"""Column -> what it is, in order."""

DTYPES = {"number": np.float64, "count": np.int64, "flag": np.bool_, "text": np.object_}
_BLANK: dict[str, Any] = {"number": np.nan, "count": 0, "flag": False, "text": ""}


@dataclass(frozen=True, eq=False)
class Windows:
    """Window table, one row per wheel and window.

    Attributes:
        columns: Name of `COLUMNS` -> values, (N,).
    """

    columns: Mapping[str, NDArray[Any]]

    @staticmethod
    def of(rows: Iterable[Mapping[str, Any]]) -> "Windows":
        """Table of rows; a column that a row lacks is NaN, 0, False or empty.

        Raises:
            InputError: A row has a column that the table has not.
        """
        listed = list(rows)
        for row in listed:
            for name in row.keys() - COLUMNS.keys():
                raise InputError(f"window table: found the column {name!r}, expected one of it")
        return Windows(
            {
                name: np.array(
                    [row.get(name, _BLANK[column.kind]) for row in listed], DTYPES[column.kind]
                )
                for name, column in COLUMNS.items()
            }
        )

    @staticmethod
    def joined(tables: "Sequence[Windows]") -> "Windows":
        """Rows of several tables, in order."""
        if not tables:
            return Windows.of([])
        return Windows({n: np.concatenate([each[n] for each in tables]) for n in COLUMNS})

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Values of a column, (N,)."""
        return self.columns[name]

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.columns["wheel"])

    @property
    def wheels(self) -> list[str]:
        """Names of the wheels, in the order of their first rows."""
        return list(dict.fromkeys(str(name) for name in self.columns["wheel"]))

    def where(self, rows: NDArray[Any]) -> "Windows":
        """Table of selected rows.

        Args:
            rows: Mask or indices of the rows.
        """
        return Windows({name: values[rows] for name, values in self.columns.items()})

    def wheel(self, name: str) -> "Windows":
        """Rows of one wheel, in order of time."""
        rows = np.flatnonzero(self.columns["wheel"] == name)
        return self.where(rows[np.argsort(self.columns["start"][rows], kind="stable")])


def write_windows(path: str | os.PathLike[str], windows: Windows) -> None:
    """Write a window table as Parquet.

    Raises:
        InputError: The file cannot be written.
    """
    import pyarrow
    import pyarrow.parquet

    kinds = {
        "number": pyarrow.float64(),
        "count": pyarrow.int64(),
        "flag": pyarrow.bool_(),
        "text": pyarrow.string(),
    }
    schema = pyarrow.schema(
        [
            pyarrow.field(
                name, kinds[column.kind], metadata={"unit": column.unit, "meaning": column.meaning}
            )
            for name, column in COLUMNS.items()
        ]
    )
    arrays = [
        pyarrow.array(windows[name].tolist(), kinds[column.kind])
        for name, column in COLUMNS.items()
    ]
    with whole_file(Path(path)) as unfinished:
        pyarrow.parquet.write_table(pyarrow.Table.from_arrays(arrays, schema=schema), unfinished)


def read_windows(path: str | os.PathLike[str]) -> Windows:
    """Read a window table from Parquet.

    Raises:
        InputError: The file cannot be read, or lacks a column.
    """
    import pyarrow.parquet

    try:
        table = pyarrow.parquet.read_table(path)
    except Exception as error:  # a damaged file makes the library raise errors of many classes
        reason = (str(error).splitlines() or [""])[0]
        raise InputError(f"{path}: found {reason!r}, expected a window table as Parquet") from None
    missing = [name for name in COLUMNS if name not in table.column_names]
    if missing:
        raise InputError(f"{path}: found no column {missing[0]!r}, expected a window table")
    return Windows(
        {
            name: np.array(table.column(name).to_pylist(), DTYPES[column.kind])
            for name, column in COLUMNS.items()
        }
    )
