"""Files of channels in groups: TDMS and HDF5, as the libraries of these formats write them."""

import datetime
import sys

import h5py
import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import read_record

TIME = 0.5 * np.arange(6)
CURRENT = np.array([0.1, -0.2, 0.3, 0.25, 0.0, 0.125])
SPEED = np.array([0.0, 60.0, 120.0, -30.0, 15.0, 30.0])
"""rpm"""


def write_hdf5(path, channels):
    """Channels {GROUP/NAME: (values, unit)}."""
    with h5py.File(path, "w") as file:
        for name, (values, unit) in channels.items():
            file[name] = values
            if unit:
                file[name].attrs["units"] = unit


def write_tdms(path, channels, **properties):
    nptdms = pytest.importorskip("nptdms", reason="found no npTDMS, of the extra bench")
    with nptdms.TdmsWriter(path) as writer:
        objects = []
        for name, (values, unit) in channels.items():
            group, _, channel = name.rpartition("/")
            units = {"unit_string": unit} if unit else {}
            objects.append(
                nptdms.ChannelObject(group, channel, np.asarray(values), {**units, **properties})
            )
        writer.write_segment(objects)


WRITERS = pytest.mark.parametrize(
    ("suffix", "write"), [(".tdms", write_tdms), (".h5", write_hdf5)], ids=["tdms", "hdf5"]
)
GOOD = {
    "Drive/Time": (TIME, "s"),
    "Drive/Current": (1000.0 * CURRENT, "mA"),
    "Drive/Speed": (SPEED, "rpm"),
}


def require_good(record):
    np.testing.assert_allclose(record.time - record.time[0], TIME, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(record.current, CURRENT, rtol=1e-12)
    np.testing.assert_allclose(record.speed, SPEED * np.pi / 30.0, rtol=1e-12)


def refused(path, **options):
    with pytest.raises(InputError) as caught:
        read_record(path, **options)
    assert str(caught.value).isprintable(), "one line"
    return str(caught.value).replace(f"{path.parent}/", "")


@WRITERS
def test_channels_with_usual_names_and_units_need_no_options(tmp_path, suffix, write):
    path = tmp_path / f"bench{suffix}"
    more = {"Drive/Counter": (np.arange(6), ""), "Chamber/Pressure": (np.arange(9.0), "mbar")}
    write(path, {**GOOD, **more})
    record = read_record(path)
    require_good(record)
    assert record.name == path.name


@WRITERS
def test_a_file_maps_channels_and_units(tmp_path, suffix, write):
    path = tmp_path / f"bench{suffix}"
    other = {"Spare/Time": (TIME + 1.0, "s"), "Spare/Iq": (CURRENT, "A")}
    write(path, {"D/Clock": (TIME * 1e3, ""), "D/Iq": (CURRENT, ""), "D/n": (SPEED, ""), **other})
    columns = tmp_path / "drive.toml"
    columns.write_text(
        '[columns]\ntime = "Clock"\ncurrent = "D/Iq"\nspeed = "n"\n'
        '[units]\ntime = "ms"\ncurrent = "mA"\nspeed = "rpm"\n'
    )
    record = read_record(path, columns, units={"current": "A"})
    require_good(record)
    assert "'D/Iq', 'Spare/Iq'" in refused(
        path, columns={"time": "Clock", "current": "Iq", "speed": "n"}
    )


def test_a_channel_of_other_times_is_not_taken_for_one_of_the_record(tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="found no npTDMS, of the extra bench")
    path = tmp_path / "bench.tdms"
    groups = (
        ("Chamber", {"Temperature": (np.arange(3.0), "degC")}, 7.0),
        ("Drive", {"Current": (CURRENT, "A"), "Speed": (SPEED, "rpm")}, 0.5),
    )
    with nptdms.TdmsWriter(path) as writer:
        for group, channels, step in groups:
            for name, (values, unit) in channels.items():
                properties = {"wf_increment": step, "unit_string": unit}
                writer.write_segment([nptdms.ChannelObject(group, name, values, properties)])
    record = read_record(path)
    require_good(record)
    assert record.temperature is None
    assert "another time base" in refused(path, columns={"temperature": "Chamber/Temperature"})


@WRITERS
def test_each_group_has_its_own_times(tmp_path, suffix, write):
    """The speed of a group with times of its own is not read at those of the current."""
    path = tmp_path / f"bench{suffix}"
    groups = {"Tacho/Timestamp": (TIME + 0.35, "s"), "Tacho/Speed": GOOD["Drive/Speed"]}
    drive = {name: GOOD[name] for name in ("Drive/Time", "Drive/Current")}
    write(path, {**drive, **groups})
    assert refused(path).endswith(
        "column 'Tacho/Speed': found another time base, expected that of 'Drive/Time', or the "
        "speed in speed_from, also of this file"
    )
    write(path, {**GOOD, "Env/Time": (TIME[:3], "s"), "Env/Temperature": (TIME[:3], "degC")})
    require_good(read_record(path))
    assert read_record(path).temperature is None


@WRITERS
def test_stated_interval_replaces_times(tmp_path, suffix, write):
    path = tmp_path / f"bench{suffix}"
    write(path, {name: GOOD[name] for name in ("Drive/Current", "Drive/Speed")})
    assert "expected one for time" in refused(path)
    columns = tmp_path / "drive.toml"
    columns.write_text('interval = "500 ms"\n')
    require_good(read_record(path, columns))


def test_waveforms_of_tdms_have_their_times(tmp_path):
    path = tmp_path / "bench.tdms"
    waveforms = {name: GOOD[name] for name in ("Drive/Current", "Drive/Speed")}
    write_tdms(path, waveforms, wf_increment=0.5, wf_start_offset=3.0)
    record = read_record(path)
    require_good(record)
    assert record.time[0] == 3.0


def test_waveforms_of_different_rates_are_refused(tmp_path):
    nptdms = pytest.importorskip("nptdms", reason="found no npTDMS, of the extra bench")
    path = tmp_path / "bench.tdms"
    with nptdms.TdmsWriter(path) as writer:
        for name, values, step in (("Current", CURRENT, 0.5), ("Speed", SPEED, 0.25)):
            properties = {"wf_increment": step, "unit_string": "A" if step == 0.5 else "rpm"}
            writer.write_segment([nptdms.ChannelObject("Drive", name, values, properties)])
    assert refused(path) == (
        "bench.tdms: column 'Drive/Speed': found another time base, expected that of 'Drive/time', "
        "or the speed in speed_from, also of this file"
    )


def test_speed_of_the_same_file_may_have_times_of_its_own(tmp_path):
    """Two waveforms of one file are read as two loggers: here 2 s apart."""
    nptdms = pytest.importorskip("nptdms", reason="found no npTDMS, of the extra bench")
    path = tmp_path / "bench.tdms"
    rng = np.random.default_rng(1)
    time = 0.1 * np.arange(1200)
    current = 0.02 + np.repeat(rng.uniform(-0.3, 0.3, 60), 20)
    torque = 0.0228 * current - 1e-4
    speed = np.append(0.0, np.cumsum(0.1 * torque / 1.5e-3))[:-1] + rng.normal(0.0, 0.3, 1200)
    with nptdms.TdmsWriter(path) as writer:
        for name, values, unit, offset in (
            ("Current", current, "A", 0.0),
            ("Speed", speed, "rad/s", -2.0),
        ):
            properties = {"wf_increment": 0.1, "wf_start_offset": offset, "unit_string": unit}
            writer.write_segment([nptdms.ChannelObject("Drive", name, values, properties)])
    record = read_record(path, speed_from=path)
    assert any("+2." in note or "+1.9" in note for note in record.notes)
    np.testing.assert_allclose(record.speed, np.interp(record.time, time, speed), atol=3.0)


def test_dates_of_tdms_are_times(tmp_path):
    path = tmp_path / "bench.tdms"
    start = datetime.datetime(2026, 3, 1, 12, 0, 0)
    dates = [start + datetime.timedelta(seconds=float(t)) for t in TIME]
    write_tdms(path, {**GOOD, "Drive/Time": (np.array(dates, "datetime64[us]"), "")})
    require_good(read_record(path))


def test_fields_of_an_hdf5_table_are_channels(tmp_path):
    path = tmp_path / "bench.h5"
    table = np.zeros(6, [("time_s", "f8"), ("current_A", "f4"), ("speed_rpm", "i2")])
    table["time_s"], table["current_A"], table["speed_rpm"] = TIME, CURRENT, SPEED
    with h5py.File(path, "w") as file:
        file["runs/first"] = table
    record = read_record(path)
    np.testing.assert_allclose(record.current, np.float32(CURRENT), rtol=1e-12)
    np.testing.assert_allclose(record.speed, SPEED * np.pi / 30.0, rtol=1e-12)


def test_packed_vectors_of_hdf5_are_unpacked_and_have_missing_samples(tmp_path):
    path = tmp_path / "bench.h5"
    packed = np.round((CURRENT - 0.05) / 2.5e-5).astype(np.int16)
    speed = SPEED.copy()
    speed[[2, 4]] = -9999.0, -1.0
    write_hdf5(path, {**GOOD, "Drive/Current": (packed, "A"), "Drive/Speed": (speed, "rpm")})
    with h5py.File(path, "a") as file:
        file["Drive/Current"].attrs.update(scale_factor=np.array([2.5e-5]), add_offset=0.05)
        file["Drive/Speed"].attrs.update(_FillValue=-9999.0, missing_value=[-1.0, -2.0])
    record = read_record(path)
    np.testing.assert_allclose(record.current, CURRENT, atol=1e-12)
    assert record.valid.tolist() == [True, True, False, True, False, True]
    np.testing.assert_allclose(record.speed[record.valid], SPEED[[0, 1, 3, 5]] * np.pi / 30.0)


@pytest.mark.parametrize("name", ["scale_factor", "_FillValue"])
def test_attributes_that_are_no_numbers_are_refused(tmp_path, name):
    path = tmp_path / "bench.h5"
    write_hdf5(path, GOOD)
    with h5py.File(path, "a") as file:
        file["Drive/Current"].attrs[name] = "two"
    expected = f"column 'Drive/Current': found attribute {name} = 'two', expected a number"
    assert expected in refused(path)


def test_two_scales_of_one_vector_are_refused(tmp_path):
    path = tmp_path / "bench.h5"
    write_hdf5(path, GOOD)
    with h5py.File(path, "a") as file:
        file["Drive/Current"].attrs["scale_factor"] = [1.0, 2.0]
    assert "found attribute scale_factor = '[1. 2.]', expected a number" in refused(path)


def test_links_of_hdf5_to_other_files_are_not_followed(tmp_path):
    path = tmp_path / "bench.h5"
    write_hdf5(tmp_path / "other.h5", GOOD)
    with h5py.File(path, "w") as file:
        file["Drive"] = h5py.ExternalLink("other.h5", "/Drive")
    assert "found no channels" in refused(path)


def test_fraction_of_the_second_is_added_to_the_time(tmp_path):
    path = tmp_path / "packets.csv"
    samples = zip(TIME, CURRENT, SPEED, strict=True)
    rows = [f"{int(t)},{round(t % 1.0 * 65536)},{i},{n}" for t, i, n in samples]
    path.write_text("\n".join(["coarse,fine,current_A,speed_rpm", *rows]) + "\n")
    columns = {"time": "coarse", "time_fine": "fine"}
    require_good(read_record(path, columns, {"time": "s", "time_fine": "s/65536"}))


@WRITERS
def test_bad_channels_are_refused_in_one_line(tmp_path, suffix, write):
    path = tmp_path / f"bench{suffix}"
    write(path, GOOD)
    names = {"time": "Drive/Time", "current": "Drive/Current", "speed": "Drive/Sped"}
    message = refused(path, columns=names)
    assert message.startswith(f"bench{suffix}: found columns 'Drive/")
    assert "expected a column 'Drive/Sped' for speed; did you mean 'Drive/Speed'?" in message
    assert "expected a column 'Bench/Current' for current" in refused(
        path, columns={"current": "Bench/Current"}
    )
    write(path, {**GOOD, "Drive/Speed": (SPEED[:-2], "rpm")})
    assert refused(path) == (
        f"bench{suffix}: column 'Drive/Speed': found 4 values, expected 6 as in 'Drive/Time'"
    )
    write(path, {**GOOD, "Drive/Speed": (SPEED, "furlong/fortnight")})
    assert "column 'Drive/Speed': found unit 'furlong/fortnight', expected a unit" in refused(path)
    write(path, {**GOOD, "Drive/Speed": (SPEED, "")})
    assert "column 'Drive/Speed': found no unit" in refused(path)
    assert refused(path, units={"speed": "rpm"}, max_samples=5) == (
        f"bench{suffix}: found more than 5 samples, expected no more: split the file, or raise "
        "max_samples"
    )


@WRITERS
def test_damaged_files_are_refused_in_one_line(tmp_path, suffix, write):
    path = tmp_path / f"bench{suffix}"
    write(path, GOOD)
    content = path.read_bytes()
    for size in range(1, len(content), max(1, len(content) // 40)):
        path.write_bytes(content[:size])
        refused(path)
    path.write_bytes(b"")
    assert "found an empty file" in refused(path)
    path.write_text("time_s,current_A,speed_rpm\n0,1,10\n1,1,11\n")
    assert "found damaged or other content" in refused(path)


def test_tdms_file_that_was_cut_off_is_refused(tmp_path, capsys):
    """npTDMS itself only warns, and reads what is left."""
    path = tmp_path / "bench.tdms"
    write_tdms(path, GOOD)
    content = path.read_bytes()
    path.write_bytes(content[:-8])
    message = refused(path)
    assert "found damaged or other content ('Last segment of file" in message or (
        "found damaged or other content ('Data size" in message
    )
    assert capsys.readouterr() == ("", "")


def test_text_values_and_matrices_are_refused(tmp_path):
    path = tmp_path / "bench.h5"
    for values, found in ((np.zeros((6, 2)), "an array of shape 6x2"), (["a"] * 6, "of type")):
        write_hdf5(path, {**GOOD, "Drive/Speed": (values, "rpm")})
        message = refused(path)
        assert "column 'Drive/Speed'" in message
        assert found in message
    write_hdf5(path, {**GOOD, "Drive/Speed": (SPEED[:, None], "rpm")})
    require_good(read_record(path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[column]\n", "key column: found an unknown key (did you mean columns?)"),
        ("columns = 3\n", "columns: found 3, expected a table"),
        ("[columns]\ntime = 3\n", "columns.time: found 3, expected a text"),
        ('[columns]\nspeeed = "n"\n', "found role 'speeed' in columns"),
        ('interval = "0 s"\n', "interval: found 0 s, expected a time above 0"),
        ('interval = "3 rpm"\n', "expected a unit of time"),
        ('interval = "1 s"\n[columns]\ntime = "t"\n', "found interval and columns.time"),
        ("[columns\n", "found invalid TOML"),
        ("packets = 3\n", "packets: found 3, expected the name of an XTCE file"),
    ],
)
def test_bad_files_of_columns_are_refused_in_one_line(tmp_path, text, message):
    path, columns = tmp_path / "bench.csv", tmp_path / "columns.toml"
    path.write_text("time_s,current_A,speed_rpm\n0,1,10\n1,1,11\n")
    columns.write_text(text)
    assert message in refused(path, columns=columns)
    assert "found no such file or directory" in refused(path, columns=tmp_path / "none.toml")


def test_missing_package_is_named_with_its_extra(tmp_path, monkeypatch, run):
    path = tmp_path / "bench.tdms"
    path.write_bytes(b"TDSm")
    monkeypatch.setitem(sys.modules, "nptdms", None)
    code, out, error = run("identify", path, "--inertia", "1e-3", "--out", tmp_path / "out")
    assert (code, out, error.count("\n")) == (2, "", 1)
    assert "bench.tdms: found no npTDMS, expected the packages of the extra bench" in error
    assert not (tmp_path / "out").exists()


def test_command_line_takes_a_file_of_columns(tmp_path, run):
    path, columns = tmp_path / "bench.h5", tmp_path / "columns.toml"
    write_hdf5(path, GOOD)
    columns.write_text('[columns]\nspeed = "Drive/Sped"\n')
    code, out, error = run(
        *("identify", path, "--columns", columns),
        *("--inertia", "1e-3", "--out", tmp_path / "out"),
    )
    assert (code, out, error.count("\n")) == (2, "", 1)
    assert "did you mean 'Drive/Speed'?" in error
