"""MDF files as asammdf writes them."""

import sys

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import read_record

TIME = 2.0 + 0.5 * np.arange(6)
CURRENT = np.array([0.1, -0.2, 0.3, 0.25, 0.0, 0.125])
RAW = np.array([0, 60, 120, -30, 15, 30], np.int16)
"""rpm / 0.5"""


def write(path, speed=RAW, unit="rpm", other="Temperature"):
    """A file of two groups with their own times: the drive, whose speed is scaled, and a tacho."""
    asammdf = pytest.importorskip("asammdf", reason="found no asammdf, of the extra bench")
    scale = {"conversion": {"a": 0.5, "b": 0.0}} if speed.dtype.kind == "i" else {}
    text = {"encoding": "utf-8"} if speed.dtype.kind == "S" else {}
    with asammdf.MDF(version="4.10" if path.suffix == ".mf4" else "3.30") as file:
        current = asammdf.Signal(1000.0 * CURRENT, TIME, unit="mA", name="Current")
        file.append([current, asammdf.Signal(speed, TIME, unit, name="Speed", **scale, **text)])
        file.append([asammdf.Signal(RAW, TIME + 0.1, "degC", name=other)])
        file.save(path, overwrite=True)


def refused(path, **options):
    with pytest.raises(InputError) as caught:
        read_record(path, **options)
    assert str(caught.value).isprintable(), "one line"
    return str(caught.value).removeprefix(f"{path.parent}/")


@pytest.mark.parametrize("suffix", [".mf4", ".mdf"])
def test_channels_have_the_physical_values_and_times_of_their_group(tmp_path, suffix):
    path = tmp_path / f"drive{suffix}"
    write(path, other="Pressure")
    record = read_record(path)
    np.testing.assert_allclose(record.time, TIME, rtol=1e-12)
    np.testing.assert_allclose(record.current, CURRENT, rtol=1e-12)
    np.testing.assert_allclose(record.speed, 0.5 * RAW * np.pi / 30.0, rtol=1e-12)


def test_values_that_the_file_calls_invalid_are_missing_samples(tmp_path):
    asammdf = pytest.importorskip("asammdf", reason="found no asammdf, of the extra bench")
    path = tmp_path / "drive.mf4"
    invalid = np.arange(6) % 4 == 2
    with asammdf.MDF(version="4.10") as file:
        speed = asammdf.Signal(0.5 * RAW, TIME, "rpm", "Speed", invalidation_bits=invalid)
        file.append([asammdf.Signal(CURRENT, TIME, "A", "Current"), speed])
        file.save(path)
    record = read_record(path)
    assert record.valid.tolist() == [True, True, False, True, True, True]
    np.testing.assert_allclose(record.current, CURRENT, rtol=1e-12)


def test_channels_of_two_groups_are_not_mixed(tmp_path):
    path = tmp_path / "drive.mf4"
    write(path)
    assert refused(path, columns={"temperature": "Temperature"}) == (
        "drive.mf4: column 'group 1/Temperature': found another time base, expected that of "
        "'group 0/time'"
    )
    assert read_record(path).temperature is None


@pytest.mark.parametrize(
    ("content", "options", "message"),
    [
        ({}, {"columns": {"speed": "Sped"}}, "did you mean 'Speed'?"),
        ({}, {"columns": {"time": "group 7/time"}}, "expected a column 'group 7/time' for time"),
        ({"unit": "furlong"}, {}, "column 'group 0/Speed': found unit 'furlong'"),
        ({"unit": ""}, {}, "column 'group 0/Speed': found no unit"),
        ({"speed": np.array([b"a"] * 6)}, {}, "column 'group 0/Speed': found values of type"),
    ],
)
def test_bad_channels_are_refused_in_one_line(tmp_path, content, options, message):
    path = tmp_path / "drive.mf4"
    write(path, other="Pressure", **content)
    options["columns"] = {"time": "group 0/time", **options.get("columns", {})}
    assert message in refused(path, **options)


@pytest.mark.parametrize("suffix", [".mf4", ".mdf"])
def test_damaged_files_are_refused_in_one_line(tmp_path, suffix, capsys):
    path = tmp_path / f"drive{suffix}"
    write(path)
    content = path.read_bytes()
    for size in range(1, len(content), len(content) // 20):
        path.write_bytes(content[:size])
        refused(path)
    path.write_text("time_s,current_A,speed_rpm\n0,1,10\n1,1,11\n")
    assert "found damaged or other content" in refused(path)
    assert capsys.readouterr() == ("", "")


def test_missing_package_is_named_with_its_extra(tmp_path, monkeypatch):
    path = tmp_path / "drive.mf4"
    path.write_bytes(b"MDF")
    monkeypatch.setitem(sys.modules, "asammdf", None)
    assert "drive.mf4: found no asammdf, expected the packages of the extra bench" in refused(path)
