"""Figures of a result, arranged in tables."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from gyrostat.exports.evidence.results import Figure


@dataclass(frozen=True)
class Pivot:
    """Figures of one group as a table.

    Attributes:
        title: Name of the group, such as a processor.
        columns: Names of the columns.
        rows: Name of a row and its values, "" where there is none.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, tuple[str, ...]], ...]


def pivots(figures: Sequence[Figure]) -> tuple[list[Pivot], list[Figure]]:
    """Tables of the figures "GROUP: ROW, COLUMN", and the other figures."""
    tables: dict[str, dict[tuple[str, str], Figure]] = {}
    others = []
    for figure in figures:
        match = re.fullmatch(r"([^:]+): ([^,]+), (.+)", figure.name)
        if match is None:
            others.append(figure)
        else:
            tables.setdefault(match[1], {})[match[2], match[3]] = figure
    return [_pivot(title, cells) for title, cells in tables.items()], others


def _pivot(title: str, cells: dict[tuple[str, str], Figure]) -> Pivot:
    units = {column: figure.unit for (_, column), figure in cells.items()}
    columns = tuple(f"{column}{f' ({unit})' * bool(unit)}" for column, unit in units.items())
    rows = [
        (row, tuple(cells[row, c].value if (row, c) in cells else "" for c in units))
        for row in dict.fromkeys(row for row, _ in cells)
    ]
    return Pivot(title, columns, tuple(rows))
