import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import Record

GOOD = {
    "name": "wheel 3",
    "time": [0.0, 0.1, 0.3],
    "current": [1.0, -1.0, 0.0],
    "speed": [0.0, np.nan, 2.0],
    "valid": [True, False, True],
}


def test_arrays_are_copied_made_float_and_locked():
    time = np.array([0, 1, 3])
    record = Record(**{**GOOD, "time": time})
    time[0] = 7
    assert record.time.dtype == np.float64
    assert record.time[0] == 0.0
    for series in (record.time, record.current, record.speed, record.valid):
        with pytest.raises(ValueError, match="read-only"):
            series[0] = 1
    assert (record.temperature, record.setpoint, record.notes) == (None, None, ())


def test_optional_series_are_kept():
    record = Record(**GOOD, temperature=[20, 21, 22], setpoint=[1, 0, -1])
    np.testing.assert_array_equal(record.temperature, [20.0, 21.0, 22.0])
    np.testing.assert_array_equal(record.setpoint, [1.0, 0.0, -1.0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"time": [0.0, 0.3, 0.3]}, "time[2]: found 0.3, expected more than the time before it"),
        ({"time": [0.0, 0.3, 0.1]}, "time[2]: found 0.1, expected more than the time before it"),
        ({"time": [0.0, np.nan, 0.1]}, "time[1]: found nan, expected a finite number"),
        ({"time": [0.0]}, "time: found 1 sample, expected at least 2"),
        ({"time": []}, "time: found 0 samples, expected at least 2"),
        ({"current": [1.0, np.inf, 0.0]}, "current[1]: found inf, expected a finite number"),
        ({"current": [1.0, 2.0]}, "current: found 2 values, expected 3, as in time"),
        (
            {"current": [[1.0], [2.0], [3.0]]},
            "current: found shape (3, 1) of float64, expected shape (N,) of real numbers",
        ),
        (
            {"current": ["1", "2", "3"]},
            "current: found shape (3,) of <U1, expected shape (N,) of real numbers",
        ),
        (
            {"current": [1j, 0, 0]},
            "current: found shape (3,) of complex128, expected shape (N,) of real numbers",
        ),
        (
            {"valid": [1, 0, 1]},
            "valid: found shape (3,) of int64, expected shape (N,) of truth values",
        ),
        (
            {"valid": [True, True, True]},
            "speed[1]: found nan, expected a finite number where valid is True, NaN elsewhere",
        ),
        (
            {"speed": [0.0, 1.0, 2.0]},
            "speed[1]: found 1.0, expected a finite number where valid is True, NaN elsewhere",
        ),
        (
            {"speed": [0.0, np.inf, 2.0]},
            "speed[1]: found inf, expected a finite number where valid is True, NaN elsewhere",
        ),
        (
            {"temperature": [1.0, np.nan, 1.0]},
            "temperature[1]: found nan, expected a finite number",
        ),
        ({"setpoint": [1.0]}, "setpoint: found 1 value, expected 3, as in time"),
    ],
)
def test_what_a_record_refuses(change, message):
    with pytest.raises(InputError) as caught:
        Record(**{**GOOD, **change})
    assert str(caught.value) == f"wheel 3: {message}"
