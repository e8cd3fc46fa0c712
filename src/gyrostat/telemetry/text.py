"""Read delimited text line by line, with bounded memory."""

import csv
import math
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain, islice, takewhile
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.units import SI_UNIT, ascii_number, known_unit
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import Chosen, Column, Header
from gyrostat.telemetry.fault import counted, fault, listed, shown, too_many

_LONGEST_LINE = 64 * 1024  # bytes
_LOOKED_AT = 24  # number of lines used to detect the delimiter
_BLANKS = " "  # delimiter that matches any number of blanks
_DELIMITERS = (",", ";", "\t", "|", _BLANKS)  # in order of preference
_TRUTH = {"true": "1", "false": "0"}
_NO_NUMBER = ("na", "n/a", "#n/a", "null", "none", "-", "--", "nil", "missing")
_METADATA = {
    **dict.fromkeys(("serial", "serial number", "s/n", "sn"), "serial"),
    **dict.fromkeys(("date", "recorded", "time stamp", "timestamp"), "date"),
    **dict.fromkeys(("operator", "tested by"), "operator"),
    **dict.fromkeys(("temperature", "temp"), "temperature"),
}
_LONGEST_REMARK, _MOST_COMMENTS = 80, 100
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?", re.ASCII)

_Line = tuple[int, str]
_Row = tuple[int, list[str]]


def text_parts(
    file: Path,
    choose: Callable[[Header], Mapping[str, Chosen]],
    max_samples: int,
    tolerant: bool = False,
    *,
    single: bool = False,
) -> Iterator[Measured]:
    """Read delimited text in parts.

    Args:
        file: A regular file.
        choose: Function from the header to role -> column.
        max_samples: Largest number of samples of a part.
        tolerant: Whether to take 'NA' and similar words as empty cells.
        single: Whether more samples than one part holds are an error.

    Returns:
        The chosen columns, in parts; the first one has no samples if the file has none.

    Raises:
        InputError: The file is not text or has no header, or a row does not match the header.
        OSError: The file cannot be read.
    """
    with file.open("rb") as stream:
        comments: list[str] = []
        lines = _from_header(_lines(file, stream), comments)
        head = list(islice(lines, _LOOKED_AT))
        if len(head) < 2:
            found = "a header and no samples" if head else "no text but comments and blanks"
            raise fault(file, found, "a header row and samples")
        delimiter = _delimiter([text for _, text in head])
        top = [(row, _cells(text, delimiter)) for row, text in head]
        rows = chain(top, ((row, _cells(text, delimiter)) for row, text in lines))
        header, header_rows = _header(file, top[:3])
        chosen = choose(header)
        numbers = _Numbers(file, delimiter, tolerant)
        width = len(header.columns)
        trailing = len(top[0][1]) > width
        samples = _check_rows(header, islice(rows, header_rows, None), trailing)
        notes = ["trailing delimiter ignored"] if any(len(c) > width for _, c in top) else []
        while True:
            part = islice(samples, max_samples)
            values, empty, sample_rows = _read_samples(chosen, part, numbers)
            marks = ["decimal comma"] if numbers.comma else []
            yield Measured(
                file, chosen, values, empty, sample_rows, (*notes, *marks), _metadata(comments)
            )
            following = next(samples, None)
            if following is None:
                return
            if single:
                raise too_many(file, max_samples, following[0])
            samples = chain([following], samples)


def _metadata(comments: Iterable[str]) -> dict[str, str]:
    """Metadata from comments before the header, such as 'serial: RW-7' and 'date = 2026-03-01'."""
    metadata = {}
    for text in comments:
        match = re.match(r"\s*#+\s*([\w /]+?)\s*[:=]\s*(.+?)\s*$", text)
        name = _METADATA.get(match[1].casefold()) if match else None
        if match and name:
            metadata[name] = match[2][:_LONGEST_REMARK]
    return metadata


def _lines(file: Path, stream: BinaryIO) -> Iterator[_Line]:
    """Number (from 1) and text of each line that is not blank."""
    row = 0
    while line := stream.readline(_LONGEST_LINE + 1):
        row += 1
        if len(line) > _LONGEST_LINE:
            raise fault(file, f"a line longer than {_LONGEST_LINE} bytes", "rows of a table", row)
        if b"\0" in line:
            raise fault(file, "a zero byte", "text in UTF-8 or Latin-1", row)
        try:
            text = line.decode("utf-8-sig" if row == 1 else "utf-8")
        except UnicodeDecodeError:
            text = line.decode("latin-1")
        text = text.rstrip("\r\n")
        if "\r" in text:
            raise fault(
                file, "a carriage return inside a line", "lines that end in LF or CRLF", row
            )
        if text.strip():
            yield row, text


def _from_header(lines: Iterator[_Line], comments: list[str]) -> Iterator[_Line]:
    """Lines without the comments before the header, which are collected."""
    for line in lines:
        if not line[1].lstrip().startswith("#"):
            yield line
            yield from lines
        elif len(comments) < _MOST_COMMENTS:
            comments.append(line[1])


def _cells(text: str, delimiter: str) -> list[str]:
    """Cells of a line, without quotes and surrounding blanks."""
    if '"' in text:
        # Parse each line separately, so that an unclosed quote cannot swallow the rest of the file.
        cells = next(csv.reader([text.strip(" ")], delimiter=delimiter, skipinitialspace=True))
    else:
        cells = text.split() if delimiter == _BLANKS else text.split(delimiter)
    return [cell.strip() for cell in cells]


def _trim(cells: list[str]) -> list[str]:
    """Cells without the empty ones at the end."""
    width = len(cells)
    while width and not cells[width - 1]:
        width -= 1
    return cells[:width]


def _is_number(cell: str) -> bool:
    """Whether a cell looks like a number; 'nan' and 'inf' do."""
    try:
        ascii_number(cell)
    except ValueError:
        return _DECIMAL_COMMA.fullmatch(cell) is not None
    return True


def _delimiter(texts: list[str]) -> str:
    """Delimiter whose rows match the header best and contain the most numbers."""

    def score(delimiter: str) -> tuple[float, float, int]:
        header, *rows = (_cells(text, delimiter) for text in texts)
        width = len(_trim(header))
        if width < 2:
            return 0.0, 0.0, 0
        fitting = sum(len(row) >= width >= len(_trim(row)) for row in rows) / len(rows)
        filled = [cell for row in rows for cell in row if cell]
        numbers = sum(_is_number(cell) for cell in filled) / max(len(filled), 1)
        return fitting * numbers, fitting, width

    return max(_DELIMITERS, key=score)


def _header(file: Path, top: list[_Row]) -> tuple[Header, int]:
    """Parse the header from the first rows; also return its number of rows.

    A row of names, optionally followed by a row of units and a row of short names, in either order.
    """
    (names_row, names), *lower_rows = [(row, _trim(cells)) for row, cells in top]
    if all(_is_number(cell) for cell in names if cell):
        expected = "column names (a line that starts with '#' is taken as a comment)"
        found = f"no names but {listed(names[:3]) or 'empty cells'}"
        raise fault(file, found, expected, names_row)
    below = list(takewhile(lambda line: _is_wording(line[1]), lower_rows))
    unit_counts = [sum(_is_unit(cell) for cell in cells) for _, cells in below]
    units_row, units, short = None, [], []
    if any(unit_counts):
        units_row, units = below.pop(unit_counts.index(max(unit_counts)))
        if below and _are_different(below[0][1]):
            short = below[0][1]
    header_rows = 1 + bool(units) + bool(short)
    for row, cells in lower_rows[: header_rows - 1]:
        if len(cells) > len(names):
            raise fault(file, counted(len(cells), "cell"), f"{len(names)} as in the header", row)
    columns = tuple(
        Column(
            index,
            tuple(name for name in (names[index], *short[index : index + 1]) if name),
            "".join(units[index : index + 1]).strip("[]()"),
        )
        for index in range(len(names))
    )
    return Header(file, columns, names_row, units_row), header_rows


def _is_wording(cells: list[str]) -> bool:
    return any(cells) and not any(_is_number(cell) for cell in cells)


def _are_different(cells: list[str]) -> bool:
    """Whether the cells can be column names; a row of 'NA' is a bad sample instead."""
    filled = [cell for cell in cells if cell]
    return len(set(filled)) == len(filled)


def _is_unit(cell: str) -> bool:
    return any(known_unit(cell.strip("[]()"), dimension) for dimension in SI_UNIT)


class _Numbers:
    """Parser for the numbers of one file, which must use one decimal mark throughout."""

    def __init__(self, file: Path, delimiter: str, tolerant: bool):
        self.file = file
        self.tolerant = tolerant
        self.comma_allowed = delimiter != ","
        self.point = False
        self.comma = False

    def read(self, cell: str, row: int, column: str) -> float:
        """Parse the number in a cell."""
        try:
            value = ascii_number(cell)
        except ValueError:
            if self.tolerant and cell.casefold() in _NO_NUMBER:
                return math.nan
            if not self.comma_allowed or _DECIMAL_COMMA.fullmatch(cell) is None:
                raise fault(self.file, shown(cell), "a number", row, column) from None
            value = float(cell.replace(",", "."))
            self.comma = True
        if not self.point:
            self.point = "." in cell
        if self.comma and self.point:
            # In such a file '1,234' may mean one thousand two hundred and thirty-four.
            expected = "one decimal mark, comma or point, in the whole file"
            raise fault(self.file, shown(cell), expected, row, column)
        return value


def _check_rows(header: Header, rows: Iterable[_Row], trailing: bool) -> Iterator[_Row]:
    """Rows that are not empty, checked against the width of the header.

    A row may end with superfluous delimiters. If the header ends with one, every row must, because
    an empty last cell could otherwise not be distinguished from a missing one.
    """
    width = len(header.columns)
    for row, cells in rows:
        if not any(cells):
            continue
        short = len(cells) < width or (trailing and len(cells) == width and not cells[-1])
        if short or any(cells[width:]):
            found = counted(len(cells) - (trailing and not cells[-1]), "cell")
            raise fault(header.file, found, f"{width} as in the header", row)
        yield row, cells


def _read_samples(
    chosen: Mapping[str, Chosen], samples: Iterable[_Row], numbers: _Numbers
) -> tuple[dict[str, NDArray[np.float64]], dict[str, NDArray[np.bool_]], NDArray[np.int64]]:
    """Numbers and empty-cell flags of the chosen columns by role, and the row of each sample."""
    rows = array("q")
    values = {role: array("d") for role in chosen}
    empty = {role: bytearray() for role in chosen}
    for row, cells in samples:
        rows.append(row)
        for role, column in chosen.items():
            cell = cells[column.index]
            if role == "valid":
                cell = _TRUTH.get(cell.lower(), cell)
            values[role].append(numbers.read(cell, row, column.name) if cell else math.nan)
            empty[role].append(not cell)
    return (
        {role: np.frombuffer(series, np.float64) for role, series in values.items()},
        {role: np.frombuffer(gaps, np.bool_) for role, gaps in empty.items()},
        np.frombuffer(rows, np.int64),
    )
