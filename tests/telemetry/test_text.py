"""Delimited text as it is found in the wild, and read all the same."""

import numpy as np
import pytest

PLAIN = "time_s,current_A,speed_rad/s\n0,1,10\n0.5,-1,20\n1.5,2,-30\n"


def assert_plain(record):
    np.testing.assert_array_equal(record.time, [0.0, 0.5, 1.5])
    np.testing.assert_array_equal(record.current, [1.0, -1.0, 2.0])
    np.testing.assert_array_equal(record.speed, [10.0, 20.0, -30.0])
    assert record.valid.all()


def test_plain(read):
    record = read(PLAIN)
    assert_plain(record)
    assert (record.name, record.notes) == ("bench.csv", ())
    assert record.temperature is None
    assert record.setpoint is None


@pytest.mark.parametrize(
    "delimiter", [",", ";", "\t", "|", " ", "   ", ", ", " ;  ", " | ", "\t\t "]
)
def test_delimiters(read, delimiter):
    assert_plain(read(PLAIN.replace(",", delimiter)))


@pytest.mark.parametrize("suffix", ["csv", "txt", "tsv", "dat", "CSV"])
def test_the_suffix_does_not_tell_the_delimiter(read, suffix):
    assert_plain(read(PLAIN.replace(",", ";"), f"bench.{suffix}"))


@pytest.mark.parametrize("delimiter", [";", "\t", "|", " "])
def test_decimal_comma(read, delimiter):
    record = read(PLAIN.replace(",", delimiter).replace(".", ","))
    assert_plain(record)
    assert record.notes == ("decimal comma",)


def test_decimal_comma_in_every_cell_and_exponents(read):
    record = read("time_s;current_A;speed_rpm\n0,0;1,5E-1;+10,0\n0,5;-1,5e0;20,0\n")
    np.testing.assert_array_equal(record.current, [0.15, -1.5])


def test_commas_in_names_do_not_make_a_delimiter(read):
    text = "time, since start [s];current, motor [A];speed, wheel [rad/s]\n"
    columns = {
        "time": "time, since start",
        "current": "current, motor",
        "speed": "speed, wheel",
    }
    assert_plain(read(text + "0,0;1,0;10,0\n0,5;-1,0;20,0\n1,5;2,0;-30,0\n", columns=columns))


def test_a_ragged_row_among_the_first_does_not_hide_the_delimiter(refusal):
    text = PLAIN.replace(",", ";").replace("0.5;-1;20", "0.5;-1")
    assert refusal(text) == "bench.csv: row 3: found 2 cells, expected 3 as in the header"


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
@pytest.mark.parametrize("last", [True, False])
def test_line_ends_and_byte_order_mark(read, ending, mark, last):
    text = PLAIN.replace("\n", ending)
    assert_plain(read(mark + (text if last else text.rstrip()).encode()))


def test_comments_before_the_header_and_blank_lines(read):
    text = "# wheel 3, bench 2\n\n  # second remark, with commas\n" + PLAIN.replace("\n", "\n \n\n")
    assert_plain(read(text))


def test_quoted_cells(read):
    text = '"time [s]","current, motor (A)","speed ""w"" [rad/s]"\n"0","1",10\n0.5,"-1","20"\n'
    columns = {"current": "current, motor", "speed": 'speed "w"'}
    record = read(text + '1.5,2,"-30"', columns=columns)
    assert_plain(record)


def test_quoted_cells_between_blanks(read):
    assert_plain(read('"time [s]"  "current [A]" "speed [rad/s]"\n 0 1 10\n 0.5 -1 20\n1.5 2 -30'))


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "cp1252"])
def test_encodings(read, encoding):
    text = "time [µs];current [A];speed [°/s];temperature [°C]\n0;1;180;21\n5;1;360;22\n"
    record = read(text.encode(encoding))
    np.testing.assert_allclose(record.time, [0.0, 5e-6], rtol=1e-15)
    np.testing.assert_allclose(record.speed, [np.pi, 2 * np.pi], rtol=1e-15)
    np.testing.assert_array_equal(record.temperature, [21.0, 22.0])


@pytest.mark.parametrize("header_too", [True, False])
@pytest.mark.parametrize("tail", [",", ",,,", " , "])
def test_trailing_delimiter(read, tail, header_too):
    header, *rows = PLAIN.splitlines()
    text = "\n".join([header + tail * header_too, *(row + tail for row in rows)])
    record = read(text)
    assert_plain(record)
    assert record.notes == ("trailing delimiter ignored",)


def test_an_empty_last_cell_is_no_trailing_delimiter(read):
    record = read("time_s,current_A,speed_rpm\n0,1,10\n1,1,\n2,1,30\n")
    np.testing.assert_array_equal(record.valid, [True, False, True])
    assert record.notes == ("1 sample marked missing",)


def test_an_empty_last_cell_before_a_trailing_delimiter(read):
    record = read("time_s,current_A,speed_rpm,\n0,1,10,\n1,1,,\n2,1,30,\n")
    np.testing.assert_array_equal(record.valid, [True, False, True])


def test_rows_of_nothing_but_delimiters_are_blank(read):
    assert_plain(read(PLAIN.replace(",", ";") + ";;\n;;\n"))


def test_an_unnamed_index_column(read):
    header, *rows = PLAIN.splitlines()
    rows = [f"{index},{row}" for index, row in enumerate(rows)]
    assert_plain(read("\n".join(["," + header, *rows])))


def test_columns_of_text_that_no_one_asks_for(read):
    header, *rows = PLAIN.splitlines()
    rows = [f'{row},"note, {index}",nan' for index, row in enumerate(rows)]
    assert_plain(read("\n".join([header + ",remark,other", *rows])))


def test_units_row(read):
    assert_plain(read("time;current;speed\nms;mA;rad/s\n0;1000;10\n500;-1000;20\n1500;2000;-30"))


def test_units_row_in_brackets_and_with_gaps(read):
    text = "no;time;current;speed;mode\n;[s];(A);[rad/s];-\n"
    assert_plain(read(text + "1;0;1;10;x\n2;0.5;-1;20;x\n3;1.5;2;-30;x"))


@pytest.mark.parametrize("units_first", [True, False])
@pytest.mark.parametrize(
    "columns",
    [
        {"speed": "wheel speed (left)"},
        {"speed": "Wheel Speed"},
        {"speed": "w1"},
        {"speed": "W1", "time": "elapsed"},
        {"speed": "w1", "time": "t", "current": "i"},
    ],
)
def test_three_header_rows_select_by_either_name(read, units_first, columns):
    rows = ["elapsed;motor current;wheel speed (left);", "s;A;rad/s;", "t;i;w1;"]
    if not units_first:
        rows[1:] = rows[:0:-1]
    assert_plain(read("\n".join([*rows, "0;1;10;", "0.5;-1;20;", "1.5;2;-30;"]), columns=columns))


def test_short_names_that_look_like_units(read):
    rows = ["elapsed;motor current;wheel speed", "s;A;w", "s;A;rad/s"]
    text = "\n".join([*rows, "0;1;10", "0.5;-1;20", "1.5;2;-30"])
    assert_plain(read(text, columns={"time": "s", "current": "A", "speed": "w"}))


def test_time_keeps_its_origin_and_its_gaps(read):
    record = read("time_s,current_A,speed_rpm\n1.7e9,0,0\n1700000000.03,0,0\n1700000100,0,0\n")
    np.testing.assert_array_equal(record.time, [1.7e9, 1700000000.03, 1700000100.0])


def test_temperature_setpoint_and_valid(read):
    record = read(
        "time_s,current_A,speed_rpm,temp_K,direction,valid\n"
        "0,1,60,293.15,1,1\n1,1,999,293.15,-1,0\n2,1,,294.15,0,true\n3,1,nan,295.15,0,False\n"
    )
    np.testing.assert_allclose(record.temperature, [20, 20, 21, 22], atol=1e-9)
    np.testing.assert_array_equal(record.setpoint, [1, -1, 0, 0])
    np.testing.assert_array_equal(record.valid, [True, False, False, False])
    np.testing.assert_array_equal(np.isnan(record.speed), ~record.valid)
    assert record.notes == ("3 samples marked missing",)


def test_setpoint_with_a_unit_is_converted(read):
    record = read("time_s,current_A,speed_rpm,setpoint_rpm\n0,1,60,60\n1,1,60,-30\n")
    np.testing.assert_allclose(record.setpoint, [2 * np.pi, -np.pi], rtol=1e-15)


def test_empty_cells_of_a_missing_sample_are_held(read):
    record = read(
        "time_s,current_A,speed_rpm,temp_C\n0,1,60,20\n1,,,\n2,,,\n3,4,60,23\n4,,,\n", max_samples=5
    )
    np.testing.assert_array_equal(record.current, [1, 1, 1, 4, 4])
    np.testing.assert_array_equal(record.temperature, [20, 20, 20, 23, 23])
    assert record.notes == (
        "3 samples marked missing",
        "current held over 3 samples",
        "temperature held over 3 samples",
    )


UNSIGNED = "time_s,current_A,speed_rpm,command\n"


def test_unsigned_current_takes_the_sign_of_the_setpoint(read):
    record = read(
        UNSIGNED + "0,1,-9,5\n1,2,9,-5\n2,3,9,0\n3,4,-9,0\n4,0,0,0\n",
        columns={"setpoint": "command"},
        unsigned_current=True,
        units={"setpoint": "rpm"},
    )
    np.testing.assert_array_equal(record.current, [1, -2, 3, -4, 0])
    assert record.notes == (
        "current unsigned: sign taken from column command, and from speed_rpm if it is 0",
    )


def test_unsigned_current_takes_the_sign_of_the_speed(read):
    record = read(UNSIGNED + "0,1,-9,5\n1,2,9,-5\n2,3,-9,5\n", unsigned_current=True)
    np.testing.assert_array_equal(record.current, [-1, 2, -3])
    assert record.notes == ("current unsigned: sign taken from column speed_rpm",)


def test_unsigned_current_keeps_its_magnitude_where_nothing_tells_the_sign(read):
    record = read(
        UNSIGNED + "0,1,0,\n1,2,-9,0\n2,3,0,0\n3,4,,0\n4,5,9,0\n5,6,0,0\n", unsigned_current=True
    )
    np.testing.assert_array_equal(record.current, [-1, -2, -3, -4, 5, 6])
    assert record.notes[-1] == "direction unknown in 4 samples: sign of current held"


def test_unsigned_current_of_a_wheel_that_never_moves(read):
    record = read(UNSIGNED + "0,1,0,0\n1,2,0,0\n", unsigned_current=True)
    np.testing.assert_array_equal(record.current, [1, 2])
