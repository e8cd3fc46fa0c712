import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gyrostat.core.any_unit import parse_any
from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM, SI_UNIT, WARMEST, find_unit, known_unit, parse_quantity, to_si


def test_si_units_are_spelled_as_the_outputs_spell_them():
    assert SI_UNIT == {
        "time": "s",
        "current": "A",
        "power": "W",
        "resistance": "Ohm",
        "speed": "rad/s",
        "torque": "N·m",
        "momentum": "N·m·s",
        "motor_constant": "N·m/A",
        "inertia": "kg·m²",
        "mass": "kg",
        "length": "m",
        "area": "m²",
        "magnetic_dipole": "A·m²",
        "flux_density": "T",
        "imbalance": "kg·m",
        "viscous": "N·m·s/rad",
        "stiffness": "N·m/rad",
        "torque_per_temperature": "N·m/°C",
        "viscous_per_temperature": "N·m·s/rad/°C",
        "temperature": "°C",
        "frequency": "Hz",
        "angle": "rad",
        "angle_random_walk": "rad/√s",
        "rate_random_walk": "rad/s/√s",
    }


@pytest.mark.parametrize(("dimension", "unit"), SI_UNIT.items())
def test_si_units_convert_exactly(dimension, unit):
    for value in (-0.0, 0.1, 1e300, 5e-324):
        converted = to_si(value, unit, dimension)
        assert (converted, math.copysign(1.0, converted)) == (value, math.copysign(1.0, value))


# Factors worked out by hand, not taken from the table.
@pytest.mark.parametrize(
    ("dimension", "spellings", "si"),
    [
        ("time", "s|S|sec|seconds", 1.0),
        ("time", "ms|msec", 0.001),
        ("time", "us|µs|\u03bcs", 1e-6),
        ("time", "min|Min", 60.0),
        ("time", "h|hours", 3600.0),
        ("current", "A|amps|Ampere", 1.0),
        ("current", "mA", 0.001),
        ("current", "uA|µA", 1e-6),
        ("power", "W|watts", 1.0),
        ("power", "mW|Milliwatt", 1e-3),
        ("resistance", "Ohm|ohms|\u03a9|\u2126", 1.0),
        ("resistance", "mOhm|mohm|m\u03a9", 1e-3),
        ("speed", "rad/s|rad / s|rad·s⁻¹|rad s^-1|rad.s-1|rad per s|RAD/S|rad/sec", 1.0),
        ("speed", "deg/s|°/s|° / s|Deg/s", 0.017453292519943295),
        ("speed", "rpm|RPM|Rpm|rev/min|r/min|1/min|min^-1|min⁻¹|U/min", 0.10471975511965977),
        ("speed", "rev/s|rps", 6.283185307179586),
        ("torque", "N·m|Nm|N.m|N m|N*m|N⋅m| N·m ", 1.0),
        ("torque", "mN·m|mNm|mN m", 0.001),
        ("torque", "uNm|µN·m", 1e-6),
        ("momentum", "N·m·s|Nms|N m s|N.m.s|kg·m²/s|kg m^2/s", 1.0),
        ("momentum", "mN·m·s|mNms", 0.001),
        ("motor_constant", "N·m/A|Nm/A|N m / A|N.m.A^-1", 1.0),
        ("motor_constant", "mN·m/A|mNm/A", 0.001),
        ("inertia", "kg·m²|kg m2|kg.m^2|kg*m^2|kgm2|kg·m**2|N·m·s²", 1.0),
        ("inertia", "kg·cm²", 1e-4),
        ("inertia", "g·cm²|gcm2|g cm^2", 1e-7),
        ("inertia", "g·m²", 1e-3),
        ("mass", "kg| kg ", 1.0),
        ("mass", "g", 0.001),
        ("length", "m|metre|Meters", 1.0),
        ("length", "cm", 0.01),
        ("length", "mm", 0.001),
        ("length", "km", 1000.0),
        ("area", "m²|m2|m^2|m**2", 1.0),
        ("area", "cm²|cm2", 1e-4),
        ("area", "mm²|mm2|mm^2", 1e-6),
        ("magnetic_dipole", "A·m²|Am2|A m²|A*m^2", 1.0),
        ("magnetic_dipole", "mA·m²|mAm²", 0.001),
        ("imbalance", "kg·m|kgm|kg m", 1.0),
        ("imbalance", "g·cm|gcm", 1e-5),
        ("imbalance", "g·mm|g mm", 1e-6),
        ("inertia", "kg·mm²", 1e-6),
        ("inertia", "g·mm²", 1e-9),
        ("viscous", "N·m·s/rad|N·m·s|Nms|N m s/rad|N·m/(rad/s)", 1.0),
        ("viscous", "mN·m·s/rad|mNms", 1e-3),
        ("viscous", "µN·m·s/rad", 1e-6),
        ("viscous", "N·m/rpm|Nm/rpm", 9.549296585513721),
        ("viscous", "mNm/rpm", 9.549296585513721e-3),
        ("angle", "rad", 1.0),
        ("angle", "deg|°|º|degrees", 0.017453292519943295),
        ("speed", "deg/h|deg/hr|°/h|º / hr|deg per hour|deg·h^-1|DEG/HR", 4.84813681109536e-6),
        ("speed", "arcsec/s|arc-sec/sec", 4.84813681109536e-6),
        ("speed", "dps", 0.017453292519943295),
        ("speed", "mrad/s", 0.001),
        ("angle_random_walk", "rad/√s|rad/sqrt(s)|rad/s^0.5|rad/s^{1/2}|rad/s/√Hz", 1.0),
        (
            "angle_random_walk",
            "deg/√h|deg/√hr|°/√ h|deg/sqrt(h)|deg/sqrt(hr)|DEG/SQRT(HR)|deg/sqrt hr|deg/rt-hr|"
            "deg/h^(1/2)|deg·h^-1/2|deg h^-0.5|deg per root hour",
            2.908882086657216e-4,
        ),
        ("angle_random_walk", "deg/√s|°/s/√Hz|(deg/s)/√Hz|dps/rtHz", 0.017453292519943295),
        ("angle_random_walk", "arcsec/√s|deg/h/√Hz|(°/hr)/sqrt(Hz)", 4.84813681109536e-6),
        ("rate_random_walk", "rad/s/√s|rad/s^(3/2)|rad/s^1.5", 1.0),
        (
            "rate_random_walk",
            "deg/h/√h|(deg/hr)/√hr|deg/hr/sqrt(hr)|deg/h^1.5|°/h^{3/2}",
            8.080228018492266e-8,
        ),
        ("rate_random_walk", "arcsec/s/√s|deg/h/√s", 4.84813681109536e-6),
    ],
)
def test_factors_and_spellings(dimension, spellings, si):
    for spelling in spellings.split("|"):
        assert to_si(1.0, spelling, dimension) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize(
    ("value", "unit", "celsius"),
    [(20.5, "degC", 20.5), (20.5, "C", 20.5), (273.15, "K", 0.0), (212.0, "degF", 100.0)],
)
def test_temperatures_have_an_offset(value, unit, celsius):
    assert to_si(value, unit, "temperature") == pytest.approx(celsius, abs=1e-12)


def test_rpm_constant():
    assert pytest.approx(to_si(1.0, "rpm", "speed"), rel=1e-16) == RPM


def test_arrays_keep_their_shape_and_numbers_become_floats():
    assert isinstance(to_si(3, "rpm", "speed"), float)
    converted = to_si(np.array([[0, 60], [30, 120]]), "rpm", "speed")
    np.testing.assert_allclose(converted, 2 * np.pi * np.array([[0, 1], [0.5, 2]]), rtol=1e-15)


@pytest.mark.parametrize(
    ("unit", "dimension"),
    [
        ("MA", "current"),  # mega
        ("MW", "power"),
        ("ma", "current"),
        ("a", "current"),
        ("MS", "time"),
        ("Ms", "time"),
        ("m s", "time"),
        ("nm", "torque"),  # nanometre
        ("M", "length"),
        ("Mm", "length"),  # megametre
        ("Kg", "mass"),
        ("m", "area"),
        ("MN·m", "torque"),
        ("Hz", "speed"),  # of radians or of revolutions?
        ("1/s", "speed"),
        ("rpm", "torque"),
        ("", "speed"),
        ("rad/", "speed"),
        ("deg/h", "angle_random_walk"),
        ("deg/√h", "speed"),
        ("deg/s·√Hz", "angle_random_walk"),  # of (deg/s)·√Hz or of deg/(s·√Hz)?
        ("deg/√h", "rate_random_walk"),
    ],
)
def test_other_units_are_refused_not_guessed(unit, dimension):
    assert known_unit(unit, dimension) is None
    with pytest.raises(InputError, match="found unit"):
        find_unit(unit, dimension, "here")


def test_an_unknown_unit_lists_the_known_and_the_nearest():
    with pytest.raises(InputError) as caught:
        find_unit("MA", "current", "--units current")
    assert str(caught.value) == (
        "--units current: found unit 'MA', expected a unit of current: A, mA, µA;"
        " did you mean 'mA' (0.001 A)?"
    )


@pytest.mark.parametrize(
    ("unit", "dimension"),
    [
        *(("deg/day", "speed"), ("deg/hs", "speed"), ("kN·m", "torque"), ("nN·m", "torque")),
        *(("deg/√day", "angle_random_walk"), ("deg/s·√Hz", "angle_random_walk")),
    ],
)
def test_a_unit_of_another_size_is_not_suggested(unit, dimension):
    with pytest.raises(InputError) as caught:
        find_unit(unit, dimension, "here")
    assert "did you mean" not in str(caught.value)


def test_a_unit_of_another_dimension_is_named_as_such():
    with pytest.raises(InputError) as caught:
        find_unit("deg/h", "angle_random_walk", "here")
    assert str(caught.value).endswith("; 'deg/h' is a unit of speed")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, [0.0, math.nan]])
def test_only_finite_numbers_convert(value):
    with pytest.raises(InputError, match="finite"):
        to_si(value, "rpm", "speed")


def test_a_number_too_large_for_si_is_refused():
    with pytest.raises(InputError, match="finite"):
        to_si(1e308, "h", "time")


@pytest.mark.parametrize(
    ("text", "dimension", "si"),
    [
        ("4rpm", "speed", 0.41887902047863906),
        ("4 rpm", "speed", 0.41887902047863906),
        (" -4.0 RPM ", "speed", -0.41887902047863906),
        ("0.418879", "speed", 0.418879),
        ("1.5e-3", "inertia", 0.0015),
        ("1.5e-3kg.m^2", "inertia", 0.0015),
        ("15000 g cm²", "inertia", 0.0015),
        ("+.5mNm", "torque", 0.0005),
        ("5.", "torque", 5.0),
        ("300 K", "temperature", 26.85),
        ("25", "temperature", 25.0),
        ("2 h", "time", 7200.0),
    ],
)
def test_quantities(text, dimension, si):
    assert parse_quantity(text, dimension, "here") == pytest.approx(si, rel=1e-14)


@pytest.mark.parametrize("text", ["", "rpm", "four rpm", "nan", "inf", "-", ".", "0x10", "1_0"])
@pytest.mark.parametrize("dimension", SI_UNIT)
def test_what_is_no_quantity_is_refused(text, dimension):
    with pytest.raises(InputError) as caught:
        parse_quantity(text, dimension, "--hold x")
    message = str(caught.value)
    assert message.startswith("--hold x")
    assert repr(text) in message
    assert SI_UNIT[dimension] in message


def test_quantity_errors_name_the_place_and_the_accepted_units():
    with pytest.raises(InputError) as caught:
        parse_quantity("4 rmp", "speed", "--hold stribeck_speed")
    assert str(caught.value) == (
        "--hold stribeck_speed '4 rmp': found unit 'rmp', expected a unit of speed:"
        " rad/s, deg/s, rpm, rev/s, deg/h, deg/min, arcsec/s, arcsec/h, ...;"
        " did you mean 'rpm' (0.1047 rad/s)?"
    )


def test_an_infinite_quantity_is_refused():
    with pytest.raises(InputError, match="finite number"):
        parse_quantity("1e999 rpm", "speed", "here")


@given(st.text(max_size=30), st.sampled_from(sorted(SI_UNIT)))
def test_any_text_is_a_finite_quantity_or_an_input_error(text, dimension):
    try:
        value = parse_quantity(text, dimension, "here")
    except InputError as error:
        message = str(error)
    else:
        message = ""
        assert math.isfinite(value)
    assert message.isprintable()


SIZES = st.floats(1e-30, 1e30)


@given(SIZES | SIZES.map(float.__neg__) | st.just(0.0), st.sampled_from(sorted(SI_UNIT)))
def test_a_bare_number_is_si_and_exact(value, dimension):
    assume(dimension != "temperature" or value <= WARMEST)  # more than that is asked for its unit
    assert parse_quantity(repr(value), dimension, "here") == value


@pytest.mark.parametrize("text", ["1e-31", "-1e31", "1e308", "1e-320", "1e999"])
def test_a_number_of_no_physical_magnitude_is_refused(text):
    with pytest.raises(InputError, match="expected a finite number, 0 or of magnitude 1e-30 to"):
        parse_quantity(text, "speed", "here")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.25", 0.25),
        ("-3e-2 N·m", -0.03),
        ("4 mN·m/rad", 4e-3),
        ("4 mN·m/deg", 4e-3 * 180.0 / math.pi),
        ("2 mN·m·s", 2e-3),  # a momentum and a viscous coefficient
        ("0.2 N·m/(deg/s)", 0.2 * 180.0 / math.pi),
        ("5 1/s", 5.0),
        ("3 rpm/V", None),
        ("3 parsec", None),
        ("1 °C/s", 1.0),
        ("0.1 deg/√h", 0.1 * math.pi / 180.0 / 60.0),
        ("3 µN·m/√s", 3e-6),
        ("3 mN·m/sqrt(h)", 5e-5),
        ("1 K/s", None),  # an offset has no place in a quotient
        ("abc", None),
        ("", None),
        ("1e400", None),
    ],
)
def test_a_text_with_any_unit_is_converted_by_it(text, value):
    if value is not None:
        assert parse_any(text, "key kp") == pytest.approx(value, rel=1e-15)
        return
    with pytest.raises(InputError, match=r"key kp: found '.*', expected a"):
        parse_any(text, "key kp")


@pytest.mark.parametrize("dimension", SI_UNIT)
def test_a_message_names_each_unit_once(dimension):
    with pytest.raises(InputError) as refused:
        parse_quantity("fast", dimension, "here")
    named = str(refused.value).partition("with a unit: ")[2].split(", ")
    assert len(named) == len(set(named))


def test_numbers_without_dimension_may_be_in_parts_per_million():
    assert parse_quantity("-500 ppm", "1", "scale") == pytest.approx(-5e-4, rel=1e-15)
    with pytest.raises(InputError, match="'ppm', expected a unit of speed"):
        parse_quantity("500 ppm", "speed", "scale")
