"""Tolerances of what is given: propagated as the exact scaling laws say."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM, parse_uncertain
from gyrostat.identification import identify, identify_dedicated

INERTIA = 1.5e-3
HALF = 0.01
LAW = {
    "inertia": {"motor_constant": 1.0, "viscous": 1.0, "coulomb": 1.0, "static": 1.0},
    "current_scale": {"motor_constant": -1.0},
    "speed_scale": {"motor_constant": 1.0, "coulomb": 1.0, "static": 1.0},
    "clock": {"motor_constant": -1.0, "viscous": -1.0, "coulomb": -1.0, "static": -1.0},
}
"""Exponents with which J dw/dt = k_m I - F(w) scales; a Stribeck speed that is held breaks the law
of the speed scale, but for the friction of a wheel without one."""


@pytest.fixture(scope="module")
def fits():
    """Fits of one record with each tolerance of 1 %, and without any."""
    found = {}

    def fit(record, name):
        if name not in found:
            tolerance = {name: HALF} if name else {}
            found[name] = identify(
                record("viscous-coulomb"),
                inertia=INERTIA,
                model="viscous-coulomb",
                speed_sigma=5.0 * RPM,
                tolerance=tolerance,
            )
        return found[name]

    return fit


@pytest.mark.parametrize("name", LAW)
def test_a_tolerance_adds_what_the_scaling_law_says(record, fits, name):
    plain, with_it = fits(record, ""), fits(record, name)
    for k, parameter in enumerate(plain.names[:3]):
        added = with_it.sigma[k] ** 2 - plain.sigma[k] ** 2
        law = LAW[name].get(parameter, 0.0) * HALF * plain.values[k]
        assert added == pytest.approx(law**2, rel=1e-3, abs=1e-4 * plain.sigma[k] ** 2)
        share = with_it.variance_shares[name][k]
        assert share == pytest.approx(added / with_it.sigma[k] ** 2, abs=1e-6)
        assert with_it.observability[parameter] == plain.observability[parameter]
    np.testing.assert_array_equal(with_it.values[:4], plain.values)


def test_an_inertia_with_a_tolerance_is_a_given_parameter(record, fits):
    """Wheels drawn from the fit keep the ratios that the record shows."""
    fit = fits(record, "inertia")
    row = fit.to_dict()["parameters"]["inertia"]
    assert row["given"]
    assert row["sigma"] == pytest.approx(HALF * INERTIA)
    assert "inertia" not in fit.held
    motor, inertia = (fit.names.index(n) for n in ("motor_constant", "inertia"))
    slope = np.zeros(len(fit.names))
    slope[motor] = 1.0 / fit.values[inertia]
    slope[inertia] = -fit.values[motor] / fit.values[inertia] ** 2
    plain = fits(record, "")
    ratio = np.sqrt(slope @ fit.covariance @ slope)
    assert ratio == pytest.approx(plain.sigma[0] / INERTIA, rel=1e-2)


def test_a_coast_scales_with_the_inertia(record):
    ramps = record("viscous-coulomb", "ramps")
    options = {"model": None, "inertia": INERTIA, "hold": {}, "speed_sigma": None}
    plain = identify_dedicated("coast", [ramps], **options)
    fit = identify_dedicated("coast", [ramps], tolerance={"inertia": HALF}, **options)
    for k, _ in enumerate(plain.names):
        expected = np.hypot(plain.sigma[k], HALF * plain.values[k])
        assert fit.sigma[k] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("1.5e-3 +- 1 %", "inertia", (1.5e-3, 0.01)),
        ("1.5 g·m² ± 30 g·cm²", "inertia", (1.5e-3, 0.002)),
        ("1.5e-3+/-3e-5", "inertia", (1.5e-3, 0.02)),
        ("1.5e-3", "inertia", (1.5e-3, 0.0)),
        ("+- 1 %", None, (None, 0.01)),
        ("1.02 ± 0.5%", None, (1.02, 0.005)),
        ("+- 50e-6", None, (None, 50e-6)),
    ],
)
def test_tolerances_are_read(text, dimension, expected):
    value, sigma = parse_uncertain(text, dimension, "--option")
    assert value == (None if expected[0] is None else pytest.approx(expected[0], rel=1e-12))
    assert sigma == pytest.approx(expected[1], rel=1e-12)


@pytest.mark.parametrize(
    ("text", "dimension", "message"),
    [
        ("1.5e-3 +- -1 %", "inertia", "expected 0 or more"),
        ("1.5e-3 +- 1 % +- 2 %", "inertia", "expected one tolerance"),
        ("1.5e-3 +- x", "inertia", "found tolerance 'x'"),
        ("+- 1e-5", "inertia", "expected a share in %"),
        ("1 A +- 1 %", None, "expected a factor"),
        ("", "inertia", "expected a number"),
        ("1.5e-3 +- 1 m%", "inertia", "found tolerance '1 m%'"),
    ],
)
def test_bad_tolerances_are_refused(text, dimension, message):
    with pytest.raises(InputError, match="--option") as caught:
        parse_uncertain(text, dimension, "--option")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("tolerance", "options", "message"),
    [
        ({"mass": 0.01}, {}, "tolerance: found 'mass'"),
        ({"inertia": 0.9}, {}, "tolerance of inertia: found 0.9"),
        ({"inertia": 0.01}, {"prior": {"inertia": (INERTIA, 1e-4)}}, "parameter that is estimated"),
    ],
)
def test_tolerances_that_make_no_sense_are_refused(record, tolerance, options, message):
    with pytest.raises(InputError) as caught:
        identify(record(), inertia=INERTIA, tolerance=tolerance, **options)
    assert message in str(caught.value)
