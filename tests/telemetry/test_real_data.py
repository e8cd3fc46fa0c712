"""The records of a mobile robot's motors, taken as they are."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.telemetry import read_record

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path("shared", "data", "robotino_dc_motor")


@pytest.fixture
def folder():
    for parent in (ROOT, *ROOT.parents):
        if (parent / FOLDER).is_dir():
            return parent / FOLDER
    pytest.skip(f"the real records are not here: no {FOLDER} in or above the repository")


@pytest.mark.parametrize(
    ("name", "samples", "duration"),
    [
        ("data_for_identification_with_integral", 2294, 70.3656),
        ("data_for_identification_without_integral", 2291, 70.3811),
        ("validation_data", 1238, 38.1028),
    ],
)
@pytest.mark.parametrize("motor", [1, 2, 3])
def test_three_motors_in_one_table(folder, name, samples, duration, motor):
    record = read_record(
        folder / f"{name}.csv",
        columns={
            "time": "t",
            "current": f"m{motor}cur",
            "speed": f"m{motor}vel",
            "setpoint": f"m{motor}setvel",
        },
        unsigned_current=True,
    )
    assert record.time.size == samples
    assert record.time[-1] == pytest.approx(duration, abs=1e-4)
    assert record.valid.all()
    assert record.notes[:2] == (
        "trailing delimiter ignored",
        f"current unsigned: sign taken from column m{motor}setvel, and from m{motor}vel if it is 0",
    )
    # Jitter is kept, and the current has the sign of the commanded direction.
    assert 0.015 < np.diff(record.time).min() < np.diff(record.time).max() < 0.08
    driven = (record.setpoint != 0.0) & (record.current != 0.0)
    np.testing.assert_array_equal(np.sign(record.current[driven]), np.sign(record.setpoint[driven]))
    assert np.abs(record.speed).max() < 250.0


def test_long_names_select_the_same_columns(folder):
    path = folder / "validation_data.csv"
    long = read_record(
        path,
        columns={"current": "2nd motor current", "speed": "2nd motor velocity", "time": "Time"},
    )
    short = read_record(path, columns={"time": "t", "current": "m2cur", "speed": "m2vel"})
    np.testing.assert_array_equal(long.speed, short.speed)
    np.testing.assert_array_equal(long.current, short.current)
