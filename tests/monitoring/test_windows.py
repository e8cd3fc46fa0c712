"""Window table: rows, selection and file."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.monitoring.windows import COLUMNS, Windows, read_windows, write_windows

ROWS = [
    {"wheel": "b", "start": 86400.0, "coulomb": 8e-4, "coulomb_observable": True, "samples": 7},
    {"wheel": "a", "start": 0.0, "why": "no current"},
    {"wheel": "b", "start": 0.0, "coulomb": 9e-4, "valid": True},
]


def test_a_file_returns_the_table(tmp_path):
    windows = Windows.of(ROWS)
    write_windows(tmp_path / "windows.parquet", windows)
    back = read_windows(tmp_path / "windows.parquet")
    for name in COLUMNS:
        np.testing.assert_array_equal(back[name], windows[name])
        assert back[name].dtype == windows[name].dtype
    assert np.isnan(back["coulomb"][1])
    assert back["why"][1] == "no current"


def test_rows_of_a_wheel_are_in_order_of_time():
    windows = Windows.of(ROWS)
    assert windows.wheels == ["b", "a"]
    np.testing.assert_array_equal(windows.wheel("b")["coulomb"], [9e-4, 8e-4])


def test_an_unknown_column_and_another_file_are_refused(tmp_path):
    with pytest.raises(InputError, match="'colour'"):
        Windows.of([{"colour": 1}])
    (tmp_path / "x.parquet").write_text("text")
    with pytest.raises(InputError, match="window table"):
        read_windows(tmp_path / "x.parquet")
