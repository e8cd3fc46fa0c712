"""Files that must be refused, each with one line that says where and why."""

import os
import tracemalloc

import pytest

from gyrostat.core.errors import InputError
from gyrostat.telemetry import read_record

HEADER = "time_s,current_A,speed_rpm\n"
GOOD = HEADER + "0,1,10\n1,1,20\n"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "found an empty file, expected a record"),
        (
            "\n  \n# a remark\n",
            "found no text but comments and blanks, expected a header row and samples",
        ),
        (HEADER, "found a header and no samples, expected a header row and samples"),
        ("time;current;speed\ns;A;rpm\n", "found 0 samples, expected at least 2"),
        (HEADER + "0,1,10\n", "found 1 sample, expected at least 2"),
        (
            "0,1,10\n1,1,20\n",
            "row 1: found no names but '0', '1', '10', expected column names"
            " (a line that starts with '#' is taken as a comment)",
        ),
        (
            "# time_s,current_A,speed_rpm\n0,1,10\n1,1,20\n",
            "row 2: found no names but '0', '1', '10', expected column names"
            " (a line that starts with '#' is taken as a comment)",
        ),
        (
            ",,\n,,\n",
            "row 1: found no names but empty cells, expected column names"
            " (a line that starts with '#' is taken as a comment)",
        ),
        (
            HEADER + "0,1,10\n1,one,20\n",
            "row 3, column 'current_A': found 'one', expected a number",
        ),
        (
            HEADER + "\n0,1,10\n\n1,1_0,20\n",
            "row 5, column 'current_A': found '1_0', expected a number",
        ),
        (
            HEADER + "x,y,z\n0,1,10\n1,1,20\n",
            "row 2, column 'time_s': found 'x', expected a number",
        ),
        (
            "time;current;speed\ns;A;rpm\nNA;NA;NA\n0;1;10\n1;1;20\n",
            "row 3, column 'time': found 'NA', expected a number",
        ),
        (
            HEADER + '0,1,10\n1,"1,5",20\n',
            "row 3, column 'current_A': found '1,5', expected a number",
        ),
        (
            "time_s;current_A;speed_rpm\n0.5;1;10\n1;1;1,234\n",
            "row 3, column 'speed_rpm': found '1,234',"
            " expected one decimal mark, comma or point, in the whole file",
        ),
        (
            HEADER + "0,1,10\n1,1,nan\n",
            "row 3, column 'speed_rpm': found nan, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            HEADER + "0,-Inf,10\n1,1,20\n",
            "row 2, column 'current_A': found -inf, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            HEADER + "0,1e999,10\n1,1,20\n",
            "row 2, column 'current_A': found inf, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            HEADER + "0,1,10\nNaN,1,20\n",
            "row 3, column 'time_s': found nan, expected a finite number",
        ),
        (
            "time_h,current_A,speed_rpm\n0,1,10\n1e308,1,20\n",
            "row 3, column 'time_h': found 1e+308, expected a finite number",
        ),
        (
            HEADER + "0,1,10\n,1,20\n",
            "row 3, column 'time_s': found an empty cell, expected a finite number",
        ),
        (
            HEADER + "0,1,10\n,,\n1,,20\n",
            "row 4, column 'current_A': found an empty cell, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            HEADER + "0,,\n1,1,20\n",
            "row 2, column 'current_A': found an empty cell, expected a finite number"
            " (a missing speed sample is an empty cell, or has 0 in a column 'valid'; "
            "--missing drop leaves such rows out)",
        ),
        (
            HEADER + "0,1,10\n0.5,1,20\n0.25,1,20\n",
            "row 4, column 'time_s': found time 0.25 after 0.5 s in row 3,"
            " expected strictly increasing time",
        ),
        (
            HEADER + "0,1,10\n# pause\n",
            "row 3: found 1 cell, expected 3 as in the header",
        ),
        (
            "time_ms,current_A,speed_rpm\n0,1,10\n\n0,1,20\n",
            "row 4, column 'time_ms': found time 0.0 after 0.0 ms in row 2,"
            " expected strictly increasing time",
        ),
        (HEADER + "0,1,10\n1,1\n", "row 3: found 2 cells, expected 3 as in the header"),
        (HEADER + "0,1,10\n1,1,20,4\n", "row 3: found 4 cells, expected 3 as in the header"),
        (
            HEADER.replace("\n", ",\n") + "0,1,10,\n1,1,\n",
            "row 3: found 2 cells, expected 3 as in the header",
        ),
        (
            'time_s,current_A,speed_rpm\n0,1,10\n"1,1,20\n',
            "row 3: found 1 cell, expected 3 as in the header",
        ),
        (
            "time;current;speed\ns;A;rpm;K\n0;1;10\n1;1;20\n",
            "row 2: found 4 cells, expected 3 as in the header",
        ),
        (
            "time_s,current_A,speed_rpm,valid\n0,1,10,1\n1,1,20,2\n",
            "row 3, column 'valid': found 2.0, expected 0 or 1",
        ),
        (
            "time_s,current_A,speed_rpm,valid\n0,1,10,1\n1,1,20,\n",
            "row 3, column 'valid': found an empty cell, expected 0 or 1",
        ),
        (
            "time_s,current_A,speed_rpm,temp_C\n0,1,10,20\n1,1,20,\n",
            "row 3, column 'temp_C': found an empty cell, expected a finite number",
        ),
        (
            HEADER + "0,1,10\n" + "1," * 40_000 + "\n",
            "row 3: found a line longer than 65536 bytes, expected rows of a table",
        ),
        (
            "x" * 70_000,
            "row 1: found a line longer than 65536 bytes, expected rows of a table",
        ),
        (
            GOOD.replace("\n", "\r"),
            "row 1: found a carriage return inside a line, expected lines that end in LF or CRLF",
        ),
        (
            b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR",
            "row 3: found a zero byte, expected text in UTF-8 or Latin-1",
        ),
        (GOOD.encode("utf-16"), "row 1: found a zero byte, expected text in UTF-8 or Latin-1"),
    ],
)
def test_content(refusal, content, message):
    assert refusal(content) == f"bench.csv: {message}"


def test_a_long_cell_is_shortened_and_kept_on_one_line(refusal):
    message = refusal(HEADER + "0,1,10\n1," + "\x1b[31mx" * 1000 + ",20\n")
    assert message.startswith("bench.csv: row 3, column 'current_A': found '\\x1b[31mx")
    assert len(message) < 200


def test_negative_values_in_a_current_called_unsigned(refusal):
    assert refusal(HEADER + "0,1,10\n1,-1,20\n", unsigned_current=True) == (
        "bench.csv: row 3, column 'current_A': found -1.0,"
        " expected no negative value in a current declared unsigned"
    )


def test_more_samples_than_wanted(read, refusal):
    assert read(GOOD, max_samples=2).time.size == 2
    assert refusal(GOOD + "2,1,30\n", max_samples=2) == (
        "bench.csv: row 4: found more than 2 samples,"
        " expected no more: split the file, or raise max_samples"
    )


def test_a_file_of_2_gb_is_refused_in_bounded_memory(tmp_path):
    path = tmp_path / "large.csv"
    rows = "".join(f"{n}.0,{n}.5,{n}.25\n" for n in range(30_000))
    path.write_text(HEADER + rows)
    os.truncate(path, 2**31)  # a hole, which takes no space
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=r"row 20002: found more than 20000 samples"):
            read_record(path, max_samples=20_000)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 2_000_000  # 20 000 samples of four numbers, and a buffer


def test_a_line_of_2_gb_is_refused_in_bounded_memory(tmp_path):
    path = tmp_path / "large.csv"
    path.write_text(GOOD)
    os.truncate(path, 2**31)
    tracemalloc.start()
    try:
        with pytest.raises(InputError, match=r"row 4: found a line longer than 65536 bytes"):
            read_record(path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 1_000_000


def refused(path):
    with pytest.raises(InputError) as caught:
        read_record(path)
    assert str(caught.value).isprintable()
    return str(caught.value)


def test_no_such_file(tmp_path):
    path = tmp_path / "absent.csv"
    assert refused(path) == (
        f"{path}: found no readable file (No such file or directory), expected a record"
    )


def test_a_folder(tmp_path):
    path = tmp_path / "folder.csv"
    path.mkdir()
    assert refused(path) == f"{path}: found a folder, expected a file"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_a_pipe_is_not_waited_for(tmp_path):
    path = tmp_path / "pipe.csv"
    os.mkfifo(path)
    assert refused(path) == f"{path}: found a pipe or device, expected a file"


def test_no_permission(tmp_path, monkeypatch):
    path = tmp_path / "secret.csv"
    path.write_text(GOOD)

    def forbid(*_args, **_options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.open", forbid)
    assert refused(path) == f"{path}: found no readable file (Permission denied), expected a record"


def test_a_disk_that_fails_while_reading(tmp_path, monkeypatch):
    path = tmp_path / "bench.csv"
    path.write_text(GOOD)

    def fail(*_args, **_options):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("gyrostat.telemetry.text._lines", fail)
    assert refused(path) == (
        f"{path}: found an unreadable file (Input/output error), expected a record"
    )


@pytest.mark.parametrize("name", ["zero\0byte.csv", "two\nlines.csv", "x" * 300 + ".csv"])
def test_names_that_no_file_has(tmp_path, name):
    assert "found no readable file" in refused(tmp_path / name)


@pytest.mark.parametrize("name", ["bench.xlsx", "bench.csv.gz", "bench", ".csv"])
def test_other_suffixes(tmp_path, name):
    path = tmp_path / name
    path.write_text(GOOD)
    listed = refused(path).partition("expected one of ")[2].split(", ")
    assert {".csv", ".txt", ".tsv", ".dat", ".parquet", ".mat", ".tdms", ".h5"} <= {*listed}
