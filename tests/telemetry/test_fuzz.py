"""Whatever the bytes: a record, or an input error of one line."""

import io

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from gyrostat.core.errors import InputError
from gyrostat.telemetry import Record, read_record

SERIES = {"time_s": [0.0, 0.5, 1.5], "current_A": [1.0, -1.0, 2.0], "speed_rpm": [1.0, 2.0, 3.0]}


def parquet():
    stream = io.BytesIO()
    pq.write_table(pa.table(SERIES), stream)
    return stream.getvalue()


def mat(do_compression):
    stream = io.BytesIO()
    savemat(stream, SERIES, do_compression=do_compression)
    return stream.getvalue()


SEEDS = {
    "csv": [
        b"time_s,current_A,speed_rpm\n0,1,10\n0.5,-1,20\n1.5,2,\n",
        b"# remark\nTime;Motor current;Speed;\nms;A;rad/s;\nt;i;w;\n0,5;1;2;\n1,5;1;2;\n",
        b'"t [s]"\t"i (mA)"\tw_deg_s\ttemp_C\tvalid\tsetpoint\n'
        b"0\t1\t2\t3\t1\t1\n1\t1\t2\t3\t0\t0\n",
    ],
    "parquet": [parquet()],
    "mat": [mat(False), mat(True)],
}
TOKENS = [
    b",",
    b";",
    b"\t",
    b" ",
    b"\n",
    b"\r",
    b'"',
    b"#",
    b"_",
    b"[",
    b"nan",
    b"1e999",
    b"-",
    b"\xb0",
]


@st.composite
def mutated(draw, seeds):
    content = bytearray(draw(st.sampled_from(seeds)))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(content)))
        length = draw(st.integers(0, 8))
        insert = draw(st.one_of(st.binary(max_size=8), st.sampled_from(TOKENS)))
        content[start : start + length] = insert
    return bytes(content)


def check(path, content, **options):
    path.write_bytes(content)
    try:
        record = read_record(path, **options)
    except InputError as error:
        message = str(error)
        assert message.isprintable()
        assert message.startswith(f"{path}: ")
        assert "found" in message
        assert "expected" in message
    else:
        assert isinstance(record, Record)
        assert np.all(np.diff(record.time) > 0.0)
        assert np.isfinite(record.current).all()


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mat"])
def test_arbitrary_bytes(tmp_path, suffix):
    path = tmp_path / f"bench.{suffix}"

    @settings(max_examples=200)
    @given(st.binary(max_size=400))
    def run(content):
        check(path, content)

    run()


@pytest.mark.parametrize("suffix", ["csv", "parquet", "mat"])
def test_damaged_files(tmp_path, suffix):
    path = tmp_path / f"bench.{suffix}"

    @settings(max_examples=200)
    @given(mutated(SEEDS[suffix]), st.booleans())
    def run(content, unsigned_current):
        check(path, content, unsigned_current=unsigned_current)

    run()


CELLS = st.one_of(
    st.sampled_from(
        ["", "0", "1", "2.5", "3,5", "-1", "nan", "inf", "true", "rpm", "s", "A", '"', "#"]
    ),
    st.floats(width=16).map(str),
    st.text(max_size=4),
)


def test_tables_of_odd_cells(tmp_path):
    path = tmp_path / "bench.csv"
    header = st.lists(
        st.sampled_from(
            [
                "time_s",
                "t",
                "current_A",
                "i [A]",
                "speed_rpm",
                "w",
                "valid",
                "temp_C",
                "direction",
                "",
            ]
        ),
        min_size=1,
        max_size=6,
    )

    @settings(max_examples=200)
    @given(header, st.lists(st.lists(CELLS, max_size=6), max_size=6), st.sampled_from(",;\t| "))
    def run(names, rows, delimiter):
        text = "\n".join(delimiter.join(row) for row in [names, *rows])
        check(path, text.encode("utf-8", "surrogatepass"), unsigned_current=True)

    run()
