"""Numbers of CSV files, and columns with units in their names."""

import csv
from pathlib import Path

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.toml_file import read_text
from gyrostat.core.types import Vector
from gyrostat.core.units import known_unit

LARGEST = 500_000_000
"""Largest file, bytes."""


def read_table(path: Path, kind: str) -> tuple[list[str], list[list[str]]]:
    """Header and rows of a CSV file.

    Args:
        path: Path of the file.
        kind: Kind of file expected, for the error message.

    Raises:
        InputError: The file cannot be read, or a row has another number of cells.
    """
    rows = list(csv.reader(read_text(path, kind, LARGEST).splitlines(), skipinitialspace=True))
    rows = [[cell.strip() for cell in row] for row in rows]
    numbered = [(k, row) for k, row in enumerate(rows, 1) if any(row) and row[0][:1] != "#"]
    if len(numbered) < 2:
        raise InputError(f"{path}: found {len(numbered)} rows, expected a header and numbers")
    header = numbered[0][1]
    for line, row in numbered[1:]:
        if len(row) != len(header):
            raise InputError(
                f"{path}: row {line}: found {len(row)} cells, expected {len(header)} as in the "
                "header"
            )
    return header, [row for _, row in numbered[1:]]


def numbers(path: Path, name: str, cells: list[str]) -> Vector:
    """Numbers of a column, (N,).

    Args:
        path: Path of the file, for the error message.
        name: Name of the column.
        cells: Texts of the column.

    Raises:
        InputError: A cell has no finite number.
    """
    values = np.empty(len(cells))
    for k, text in enumerate(cells):
        try:
            values[k] = float(text)
        except ValueError:
            values[k] = np.nan
        if not np.isfinite(values[k]):
            raise InputError(
                f"{path}: column {name}, row {k + 1} of the numbers: found {text!r}, expected a "
                "finite number"
            )
    return values


def factor_of(path: Path, header: list[str], word: str, dimension: str) -> tuple[int, float]:
    """Place of the column named WORD or WORD_UNIT, and the SI value of its unit.

    Raises:
        InputError: There is none, or its unit is unknown.
    """
    for k, name in enumerate(header):
        start, _, unit = name.partition("_")
        if start.casefold() != word:
            continue
        known = known_unit(unit, dimension) if unit else None
        if known is None:
            raise InputError(
                f"{path}: column {name}: found no unit of a {dimension}, expected {word}_UNIT, "
                f"such as {'speed_rpm' if word == 'speed' else 'frequency_Hz'}"
            )
        return k, known.factor
    raise InputError(f"{path}: found columns {', '.join(header[:8])}, expected {word}_UNIT")
