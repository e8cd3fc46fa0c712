import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gyrostat.core.errors import InputError
from gyrostat.telemetry import Record, read_record, write_record

NUMBER = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def records(draw):
    time = sorted(draw(st.sets(NUMBER, min_size=2, max_size=40)))
    count = len(time)

    def series():
        return np.array(draw(st.lists(NUMBER, min_size=count, max_size=count)))

    valid = np.array(draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    return Record(
        name="bench",
        time=time,
        current=series(),
        speed=np.where(valid, series(), np.nan),
        valid=valid,
        temperature=series() if draw(st.booleans()) else None,
        setpoint=series() if draw(st.booleans()) else None,
    )


def bits(series):
    """Comparable bit by bit: signs of zero too, but not which NaN marks a missing sample."""
    return None if series is None else np.where(np.isnan(series), np.nan, series).tobytes()


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_read_returns_what_was_written(tmp_path, suffix):
    path = tmp_path / f"bench.{suffix}"

    @settings(max_examples=200 if suffix == "csv" else 60)
    @given(records())
    def check(record):
        write_record(record, path)
        back = read_record(path)
        assert back.name == path.name
        assert back.valid.tobytes() == record.valid.tobytes()
        for field in ("time", "current", "speed", "temperature", "setpoint"):
            assert bits(getattr(back, field)) == bits(getattr(record, field))

    check()
    assert os.listdir(tmp_path) == [path.name]


def small(**change):
    series = {"time": [0.0, 0.1], "current": [1.0, -1.0], "speed": [0.1, np.nan]}
    return Record(name="bench", valid=[True, False], **{**series, **change})


def test_what_the_file_looks_like(tmp_path):
    write_record(small(temperature=[20.0, 20.5], setpoint=[1, -1]), tmp_path / "bench.csv")
    assert (tmp_path / "bench.csv").read_bytes() == (
        b"time_s,current_A,speed_rad/s,temperature_degC,setpoint\n"
        b"0.0,1.0,0.1,20.0,1.0\n0.1,-1.0,,20.5,-1.0\n"
    )


def test_long_records_are_written_whole(tmp_path):
    time = np.arange(25_001) / 7.0
    record = Record("bench", time, -time, np.sqrt(time), np.ones(time.size, bool))
    write_record(record, tmp_path / "long.csv")
    assert bits(read_record(tmp_path / "long.csv").speed) == bits(record.speed)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_file_is_replaced_and_has_the_usual_permissions(tmp_path, suffix):
    path = tmp_path / f"bench.{suffix}"
    path.write_text("old")
    write_record(small(), path)
    (tmp_path / "other").write_text("")
    assert read_record(path).time.size == 2
    assert path.stat().st_mode == (tmp_path / "other").stat().st_mode


def refused(path):
    with pytest.raises(InputError) as caught:
        write_record(small(), path)
    return str(caught.value)


@pytest.mark.parametrize("suffix", ["csv", "parquet"])
def test_a_folder_that_is_not_there_is_made(tmp_path, suffix):
    path = tmp_path / "absent" / f"bench.{suffix}"
    write_record(small(), path)
    assert read_record(path).time.size == 2


def test_a_folder_of_that_name(tmp_path):
    path = tmp_path / "bench.csv"
    path.mkdir()
    assert refused(path) == (
        f"{path}: found no way to write it (Is a directory), expected a writable folder"
    )
    assert os.listdir(tmp_path) == [path.name]


def test_a_name_that_no_file_has(tmp_path):
    assert "found no way to write it" in refused(tmp_path / "zero\0byte.csv")


def test_a_full_disk_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "bench.csv"
    path.write_text("old")

    def fail(file, _columns):
        file.write_text("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("gyrostat.telemetry.write._write_csv", fail)
    assert refused(path) == (
        f"{path}: found no way to write it (No space left on device), expected a writable folder"
    )
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == [path.name]


@pytest.mark.parametrize("name", ["bench.mat", "bench.txt", "bench"])
def test_other_suffixes(tmp_path, name):
    assert refused(tmp_path / name).endswith("expected one of .csv, .parquet")
    assert os.listdir(tmp_path) == []
