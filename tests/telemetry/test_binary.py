"""Parquet and MATLAB files."""

import io
import struct

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.io import loadmat, savemat

from gyrostat.telemetry import read_record

GOOD = {
    "time_s": [0.0, 0.5, 1.5],
    "current_mA": [1000, -1000, 2000],
    "speed_rad_s": np.array([10, 20, -30], dtype=np.int16),
}


def parquet(columns):
    stream = io.BytesIO()
    table = pa.table(list(columns.values()), names=list(columns)) if columns else pa.table({})
    pq.write_table(table, stream)
    return stream.getvalue()


def mat(columns, **options):
    stream = io.BytesIO()
    savemat(stream, columns, **options)
    return stream.getvalue()


FORMATS = pytest.mark.parametrize(
    ("name", "pack"), [("bench.parquet", parquet), ("bench.mat", mat)], ids=["parquet", "mat"]
)


@FORMATS
def test_plain(read, name, pack):
    valid = np.array([True, True, False])
    more = {"remark": ["a", "b", "c"], "temp_degC": np.float32([20, 21, 22]), "valid": valid}
    record = read(pack({**GOOD, **more}), name)
    np.testing.assert_array_equal(record.time, [0.0, 0.5, 1.5])
    np.testing.assert_allclose(record.current, [1.0, -1.0, 2.0], rtol=1e-15)
    np.testing.assert_array_equal(record.speed, [10.0, 20.0, np.nan])
    np.testing.assert_array_equal(record.valid, valid)
    np.testing.assert_array_equal(record.temperature, [20.0, 21.0, 22.0])
    assert record.name == name
    assert record.notes == ("1 sample marked missing",)


@FORMATS
def test_names_and_units_of_the_caller(read, name, pack):
    columns = {"clock": [0, 1, 2], "i1": [1.0, 2.0, 3.0], "w1": [60, 60, 60]}
    record = read(
        pack(columns),
        name,
        columns={"time": "clock", "current": "i1", "speed": "w1"},
        units={"time": "ms", "current": "A", "speed": "rpm"},
    )
    np.testing.assert_allclose(record.time, [0.0, 0.001, 0.002], rtol=1e-15)
    np.testing.assert_allclose(record.speed, 2 * np.pi, rtol=1e-15)


@pytest.mark.parametrize("oned_as", ["row", "column"])
@pytest.mark.parametrize("do_compression", [True, False])
def test_matlab_vectors_of_either_direction(read, oned_as, do_compression):
    content = mat(GOOD, oned_as=oned_as, do_compression=do_compression)
    np.testing.assert_array_equal(read(content, "bench.mat").speed, [10.0, 20.0, -30.0])


def test_parquet_null_is_an_empty_cell(read):
    columns = {**GOOD, "current_mA": [1000, None, 2000], "speed_rad_s": [10, None, -30]}
    record = read(parquet(columns), "bench.parquet")
    np.testing.assert_array_equal(record.valid, [True, False, True])
    np.testing.assert_allclose(record.current, [1.0, 1.0, 2.0], rtol=1e-15)
    assert record.notes == ("1 sample marked missing", "current held over 1 sample")


def test_a_missing_matlab_sample_is_told_by_valid(read):
    columns = {**GOOD, "speed_rad_s": [10, np.nan, -30], "valid": [1.0, 0.0, 1.0]}
    np.testing.assert_array_equal(read(mat(columns), "bench.mat").valid, [True, False, True])


@FORMATS
@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (
            {"speed_rad_s": [1.0, np.nan, 2.0]},
            {},
            "row 2, column 'speed_rad_s': found nan, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            {"time_s": [0.0, 1.0, 1.0]},
            {},
            "row 3, column 'time_s': found time 1.0 after 1.0 s in row 2,"
            " expected strictly increasing time",
        ),
        (
            {},
            {"max_samples": 2},
            "found more than 2 samples, expected no more: split the file, or raise max_samples",
        ),
        (
            {},
            {"columns": {"speed": "sped"}},
            "found columns 'time_s', 'current_mA', 'speed_rad_s', expected a column 'sped'"
            " for speed; did you mean 'speed_rad_s'?",
        ),
        (
            {},
            {"unsigned_current": True},
            "row 2, column 'current_mA': found -1000.0,"
            " expected no negative value in a current declared unsigned",
        ),
    ],
)
def test_bad_content(refusal, name, pack, change, options, message):
    assert refusal(pack({**GOOD, **change}), name, **options) == f"{name}: {message}"


@pytest.mark.parametrize("kind", [pa.string(), pa.timestamp("ms"), pa.decimal128(21, 1)])
def test_parquet_columns_that_hold_no_numbers(refusal, kind):
    values = pa.array([0, 1, 2]).cast(pa.int64()).cast(kind)
    message = refusal(parquet({**GOOD, "time_s": values}), "bench.parquet")
    assert message == (
        f"bench.parquet: column 'time_s': found values of type {kind}, expected numbers"
    )


def test_a_column_twice_in_parquet(refusal):
    content = io.BytesIO()
    names = ["time_s", "current_A", "speed_rpm", "speed_rpm"]
    pq.write_table(pa.table([pa.array([0.0, 1.0])] * 4, names=names), content)
    message = refusal(content.getvalue(), "bench.parquet")
    assert message == "bench.parquet: found column 'speed_rpm' twice, expected one for speed"


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ("text", "found 1x4 of char, expected a vector of real numbers"),
        (np.eye(3), "found 3x3 of numbers, expected a vector of real numbers"),
        ({"x": 1.0}, "found 1x1 of struct, expected a vector of real numbers"),
        ([1j, 2, 3], "found 1x3 of complex numbers, expected a vector of real numbers"),
        ([1.0, 2.0], "found 2 values, expected 3 as in 'time_s'"),
        ([], "found 0x0 of numbers, expected a vector of real numbers"),
    ],
)
def test_matlab_variables_that_are_no_vectors(refusal, values, message):
    found = refusal(mat({**GOOD, "speed_rad_s": values}), "bench.mat")
    assert found == f"bench.mat: column 'speed_rad_s': {message}"


def test_a_scalar_record(refusal):
    content = mat({"time_s": 0.0, "current_A": 1.0, "speed_rpm": 2.0})
    assert refusal(content, "bench.mat") == "bench.mat: found 1 sample, expected at least 2"


def test_an_empty_parquet_table(refusal):
    content = parquet({name: np.zeros(0) for name in GOOD})
    assert refusal(content, "bench.parquet") == (
        "bench.parquet: found 0 samples, expected at least 2"
    )


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (
            b"MATLAB 7.3 MAT-file".ljust(124) + b"\0\x02IM" + b"\0" * 384 + b"\x89HDF\r\n\x1a\n",
            "a MATLAB file of version 7.3 (HDF5)",
        ),
        (mat({"time_s": [0.0, 1.0]}, format="4"), "other content"),
    ],
)
def test_other_matlab_versions(refusal, content, found):
    assert refusal(content, "bench.mat") == (
        f"bench.mat: found {found},"
        " expected a MATLAB file of version 5 to 7 (MATLAB: save with '-v7'), or CSV"
    )


def element(kind, payload):
    return struct.pack(">II", kind, len(payload)) + payload.ljust(-(-len(payload) // 8) * 8, b"\0")


def matrix(name, values, stored=9, shape=(1, 3)):
    """A MATLAB vector of doubles as a big-endian machine writes it."""
    parts = (
        element(6, struct.pack(">II", 6, 0)),
        element(5, struct.pack(">ii", *shape)),
        element(1, name.encode()),
        element(stored, struct.pack(">3d", *values)),
    )
    return element(14, b"".join(parts))


BIG_ENDIAN = b"MATLAB 5.0 MAT-file".ljust(124) + b"\x01\x00MI"
OBJECT = element(14, element(6, struct.pack(">II", 17, 0)) + element(1, b"table"))


def test_matlab_files_of_a_big_endian_machine_and_with_objects(read):
    vectors = [matrix(name, values) for name, values in GOOD.items()]
    record = read(BIG_ENDIAN + OBJECT + b"".join(vectors), "bench.mat")
    np.testing.assert_array_equal(record.speed, [10.0, 20.0, -30.0])


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (matrix("speed_rpm", [1, 2, 3], stored=8), "24 bytes of type 8 for 3 numbers"),
        (matrix("speed_rpm", [1, 2, 3], shape=(4, 1)), "24 bytes of type 9 for 4 numbers"),
        (matrix("s" * 2000, [1, 2, 3]), "a variable without class, shape and name"),
        (element(3, b"12345678"), "element of type 3 and 8 bytes at byte 312"),
    ],
    ids=["type", "count", "name", "element"],
)
def test_matlab_files_that_contradict_themselves(refusal, bad, reason):
    good = [matrix("time_s", [0, 1, 2]), matrix("current_A", [0, 1, 2])]
    assert refusal(BIG_ENDIAN + b"".join(good) + bad, "bench.mat") == (
        f"bench.mat: found damaged or other content ({reason!r}),"
        " expected a MATLAB file of version 5 to 7"
    )


def test_matlab_numbers_that_end_before_their_variable(refusal):
    vectors = [matrix(name, values) for name, values in GOOD.items()]
    content = bytearray(BIG_ENDIAN + b"".join(vectors))
    short = len(vectors[-1]) - 8 - 16  # the last two numbers lie beyond it
    content[-len(vectors[-1]) + 4 : -len(vectors[-1]) + 8] = struct.pack(">I", short)
    assert "'data that ends too soon'" in refusal(bytes(content[:-16]), "bench.mat")


VECTORS = hnp.arrays(
    st.sampled_from([*"bBhHiIqQfd", ">f8", ">i2"]).map(np.dtype),
    st.integers(2, 50),
    elements={"allow_nan": False, "allow_infinity": False},
)


@given(VECTORS, st.booleans(), st.sampled_from(["row", "column"]), st.integers(1, 31))
def test_matlab_vectors_are_read_as_scipy_reads_them(
    tmp_path_factory, speed, do_compression, oned_as, length
):
    columns = {
        "remark": "text",
        "cells": np.array(["a", 1], dtype=object),
        "t": np.arange(speed.size),
        "i": np.zeros(speed.size),
        "w" * length: speed,
    }
    path = tmp_path_factory.getbasetemp() / "bench.mat"
    savemat(path, columns, do_compression=do_compression, oned_as=oned_as)
    names = {"time": "t", "current": "i", "speed": "w" * length}
    record = read_record(path, names, {"time": "s", "current": "A", "speed": "rad/s"})
    np.testing.assert_array_equal(record.speed, loadmat(path)["w" * length].ravel())


def test_damage_in_compressed_numbers_is_seen(refusal):
    random = np.random.default_rng(0)
    columns = {**GOOD, "speed_rad_s": random.normal(size=500), "time_s": np.arange(500.0)}
    content = bytearray(mat({**columns, "current_mA": np.ones(500)}, do_compression=True))
    content[-1000] ^= 1
    assert "found damaged or other content" in refusal(bytes(content), "bench.mat")


@FORMATS
@pytest.mark.parametrize(
    "content", [b"", b"x", b"PAR1" * 50, b"\0" * 500, b"time_s,current_A\n0,1"]
)
def test_files_that_are_something_else(refusal, name, pack, content):
    message = refusal(content, name)
    assert ("other content" if content else "an empty file") in message


@FORMATS
def test_a_truncated_file(refusal, name, pack):
    assert "found damaged or other content" in refusal(pack(GOOD)[:-20], name)
