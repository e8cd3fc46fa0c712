"""Attitude tables of a reference, from the text of a CSV file."""

import numpy as np

from gyrostat.control.guidance import Table
from gyrostat.core.errors import InputError, placed


def attitude_table(place: str, text: str) -> Table:
    """Interpolated attitude from the text of a CSV file: time, s, and quaternion in each line.

    Args:
        place: File, for the error message.
        text: Content of the file. The first line may be a header.

    Raises:
        InputError: A line is not five numbers, or `Table.of` refuses them.
    """
    rows = []
    for number, line in enumerate(text.splitlines(), 1):
        cells = line.replace(";", ",").split(",")
        try:
            row = [float(cell) for cell in cells]
        except ValueError:
            row = []
        if len(row) == 5:
            rows.append(row)
        elif line.strip() and number > 1:
            raise InputError(
                f"{place}, line {number}: found {line[:60]!r}, expected five numbers: time, s, and "
                "quaternion, scalar first"
            )
    array = np.array(rows, dtype=float).reshape(-1, 5)
    with placed(place):
        return Table.of(array[:, 0], array[:, 1:])
