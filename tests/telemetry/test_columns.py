"""Which column is taken for what, and in which unit."""

import numpy as np
import pytest

ROWS = "\n0,1,60\n1,1,60\n"


@pytest.mark.parametrize(
    "header",
    [
        "time_s,current_A,speed_rpm",
        "TIME_S,Current_A,Speed_RPM",
        "t_s,i_A,w_rpm",
        "t [s],I [A],omega [rpm]",
        "t (s),I (A),Omega(rev/min)",
        "t_s,i_A,velocity_rev/min",
        "t_s,i_A,speed_rev_per_min",
        "t_s,i_A,ω [1/min]",
        "t_sec,i_amps,speed_rev_min",
    ],
)
def test_usual_names_and_units(read, header):
    np.testing.assert_allclose(read(header + ROWS).speed, 2 * np.pi, rtol=1e-15)


@pytest.mark.parametrize(
    ("unit", "si"),
    [
        ("_rad_s", 60.0),
        ("_rad/s", 60.0),
        (" [rad/s]", 60.0),
        ("_deg_s", np.pi / 3),
        ("(°/s)", np.pi / 3),
        ("_rps", 120 * np.pi),
    ],
)
def test_units_of_speed(read, unit, si):
    record = read(f"time_s,current_A,speed{unit}" + ROWS)
    np.testing.assert_allclose(record.speed, si, rtol=1e-15)


@pytest.mark.parametrize("name", ["wheel_speed_rpm", "Wheel_Speed_RPM", "wheel_speed"])
def test_a_named_column_by_its_name_with_or_without_unit(read, name):
    record = read("time_s,current_A,wheel_speed_rpm" + ROWS, columns={"speed": name})
    np.testing.assert_allclose(record.speed, 2 * np.pi, rtol=1e-15)


def test_the_exact_name_comes_before_the_name_in_another_case(read):
    text = "time_s,current_A,W_rpm,w_rpm\n0,1,3,60\n1,1,3,60\n"
    record = read(text, columns={"speed": "w_rpm"})
    np.testing.assert_allclose(record.speed, 2 * np.pi, rtol=1e-15)


def test_a_named_column_is_not_taken_for_another_role(read):
    text = "time_s,current_A,speed_rpm,measured_rpm\n0,1,30,60\n1,1,30,60\n"
    record = read(text, columns={"setpoint": "speed_rpm", "speed": "measured_rpm"})
    np.testing.assert_allclose(record.speed, 2 * np.pi, rtol=1e-15)
    np.testing.assert_allclose(record.setpoint, np.pi, rtol=1e-15)


def test_direction_is_another_name_of_setpoint(read):
    text = "time_s,current_A,speed_rpm,sense\n0,1,30,1\n1,1,30,-1\n"
    record = read(text, columns={"direction": "sense"})
    np.testing.assert_array_equal(record.setpoint, [1.0, -1.0])


def test_units_of_the_caller_add_and_overrule(read):
    units = {"time": "ms", "current": "mA", "speed": "rpm"}
    record = read("time,current_A,speed_rad_s" + ROWS, units=units)
    np.testing.assert_allclose(record.time, [0.0, 0.001], rtol=1e-15)
    np.testing.assert_allclose(record.current, 0.001, rtol=1e-15)
    np.testing.assert_allclose(record.speed, 2 * np.pi, rtol=1e-15)


@pytest.mark.parametrize(
    ("header", "options", "message"),
    [
        (
            "time_s,amperes,speed_rpm",
            {},
            "row 1: found columns 'time_s', 'amperes', 'speed_rpm', expected one for current,"
            " called current or i, or assigned in columns",
        ),
        (
            "time_s,curent_A,speed_rpm",
            {},
            "row 1: found columns 'time_s', 'curent_A', 'speed_rpm', expected one for current,"
            " called current or i, or assigned in columns; did you mean 'curent_A'?",
        ),
        (
            "time_s,current_A,wheel_rpm",
            {"columns": {"speed": "Whel"}},
            "row 1: found columns 'time_s', 'current_A', 'wheel_rpm', expected a column 'Whel'"
            " for speed; did you mean 'wheel_rpm'?",
        ),
        (
            "time_s,speed_rpm,speed_rpm,current_A",
            {},
            "row 1: found column 'speed_rpm' twice, expected one for speed",
        ),
        (
            "time_s,w,w,current_A",
            {"columns": {"speed": "w"}},
            "row 1: found column 'w' twice, expected one for speed",
        ),
        (
            "time_s,speed_rpm,omega_rpm,current_A",
            {},
            "row 1: found columns 'speed_rpm', 'omega_rpm', expected one for speed,"
            " or an assignment in columns",
        ),
        (
            "time_s,current_A,current_mA,speed_rpm",
            {"columns": {"current": "current"}},
            "row 1: found columns 'current_A', 'current_mA', expected one for current,"
            " or an assignment in columns",
        ),
        (
            "time_s,current_A,speed_rpm",
            {"columns": {"speed": "speed", "setpoint": "speed_rpm"}},
            "found one column for two roles, expected a column of its own for each role",
        ),
        (
            "time_s,current_A,speed_rpm",
            {"columns": {"speeed": "speed_rpm"}},
            "found role 'speeed' in columns, expected one of time, current, speed, angle,"
            " time_fine, temperature, setpoint, reference, torque, valid",
        ),
        (
            "time_s,current_A,speed_rpm",
            {"columns": {"setpoint": "a", "direction": "b"}},
            "found setpoint and direction in columns, expected one of the two",
        ),
        (
            "time_s,current_A,speed_rpm",
            {"units": {"valid": "rpm"}},
            "found role 'valid' in units, expected one of time, current, speed, angle, time_fine,"
            " temperature, setpoint, reference, torque",
        ),
        (
            "time_s,current_A,speed",
            {},
            "row 1, column 'speed': found no unit, expected one in the header ('speed [rad/s]'),"
            " in a row of units, or in units",
        ),
        (
            "time_s,current_A,speed [knots]",
            {},
            "row 1, column 'speed [knots]': found unit 'knots', expected a unit of speed:"
            " rad/s, deg/s, rpm, rev/s, deg/h, deg/min, arcsec/s, arcsec/h, ...",
        ),
        (
            "time_s,current_A,speed_Hz",
            {},
            "row 1, column 'speed_Hz': found unit 'Hz', expected a unit of speed:"
            " rad/s, deg/s, rpm, rev/s, deg/h, deg/min, arcsec/s, arcsec/h, ...;"
            " 'Hz' is a unit of frequency",
        ),
        (
            "time_s,current_MA,speed_rpm",
            {},
            "row 1, column 'current_MA': found unit 'MA', expected a unit of current: A, mA, µA;"
            " did you mean 'mA' (0.001 A)?",
        ),
        (
            "time_s,current_A,speed",
            {"units": {"speed": "rmp"}},
            "column 'speed': found unit 'rmp', expected a unit of speed: rad/s, deg/s, rpm, rev/s,"
            " deg/h, deg/min, arcsec/s, arcsec/h, ...; did you mean 'rpm' (0.1047 rad/s)?",
        ),
        (
            "time;current_A;speed_rpm\nfortnights;A;rpm",
            {},
            "row 2, column 'time': found unit 'fortnights', expected a unit of time:"
            " s, ms, µs, ns, min, h, d",
        ),
        (
            "time;current;speed_rpm\ns;A;rad/s",
            {},
            "row 1, column 'speed_rpm': found units rad/s and rpm, expected one unit",
        ),
    ],
)
def test_what_is_missing_ambiguous_or_unknown(refusal, header, options, message):
    rows = ROWS.replace(",", ";") if ";" in header else ROWS
    assert refusal(header + rows, **options) == f"bench.csv: {message}"


def test_a_long_list_of_columns_is_shortened(refusal):
    message = refusal(",".join(f"x{n}" for n in range(1000)) + "\n" + ",".join(["0"] * 1000))
    assert "'x29' and 970 more, expected one for current" in message
