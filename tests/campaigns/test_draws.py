"""Draws: distributed as asked, and dependent on nothing but seed, run and key."""

import dataclasses
import zlib

import numpy as np
import pytest
from scipy import stats

from gyrostat.campaigns.draws import check_draws, draw, shares
from gyrostat.core.errors import InputError
from gyrostat.scenario import Dispersion
from gyrostat.scenario.scenario import Event
from gyrostat.scenario.schema import GUARD

RUNS = np.arange(4096)
SPREAD = ((3e-9, 0.0), (-4e-7, 3e-7))


@pytest.fixture(scope="module")
def wide(scenario):
    """The small scenario with one dispersion of each kind."""
    return dataclasses.replace(
        scenario,
        dispersions=(
            Dispersion(("start.rate.x",), "normal", ((0.01,),)),
            Dispersion(("event.loss.time",), "uniform", ((6.0, 10.0),)),
            Dispersion(("controller.turn_gain",), "log_normal", ((0.5,),)),
            Dispersion(("wheel.a.viscous", "wheel.a.coulomb"), "covariance", SPREAD),
        ),
    )


@pytest.fixture(scope="module")
def values(wide):
    return draw(wide, 3, RUNS)[0]


def test_distributions_are_those_asked_for(values):
    for column, expected in (
        (values[:, 0], stats.norm(0.0, 0.01)),
        (values[:, 1], stats.uniform(6.0, 4.0)),
        (values[:, 2], stats.lognorm(0.5, scale=0.4)),
        (values[:, 3], stats.norm(1e-7, 3e-9)),
        (values[:, 4], stats.norm(2e-5, 5e-7)),
    ):
        assert stats.kstest(column, expected.cdf).pvalue > 1e-3


def test_shares_are_midpoints_of_equal_intervals(wide):
    """Odd multiples of 2^-54, so that neither 0 nor 1 is drawn; above 1/2 they are rounded."""
    share = shares(wide, 3, RUNS)
    multiples = np.ldexp(share[share < 0.5], 54)
    assert len(multiples) > 9000
    np.testing.assert_array_equal(multiples % 2.0, 1.0)


def test_the_correlation_is_that_of_the_covariance(values):
    spread = np.array(SPREAD)
    covariance = spread @ spread.T
    expected = covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    assert expected == pytest.approx(-0.8)
    rho = np.corrcoef(values.T)
    assert rho[3, 4] == pytest.approx(expected, abs=0.03)
    others = rho - np.eye(5)
    others[3, 4] = others[4, 3] = 0.0
    assert np.max(np.abs(others)) < 5.0 / np.sqrt(len(RUNS))


def test_a_run_draws_the_same_whoever_else_is_drawn(wide, values):
    some, noise = draw(wide, 3, [4000, 7, 7])
    np.testing.assert_array_equal(some, values[[4000, 7, 7]])
    assert noise[1] == noise[2]
    assert noise[0] != noise[1]
    assert np.all(draw(wide, 4, [7])[0] != values[7])


def test_one_more_dispersion_changes_no_other(wide, values):
    fewer = dataclasses.replace(wide, dispersions=wide.dispersions[1:])
    np.testing.assert_array_equal(draw(fewer, 3, RUNS[:9])[0], values[:9, 1:])


def test_names_with_equal_checksums_do_not_share_their_draws(wide):
    """CRC-32 cannot tell these names apart."""
    first, second = "wheel.gnyijstj.coulomb", "wheel.etislvlf.coulomb"
    assert zlib.crc32(first.encode()) == zlib.crc32(second.encode())
    alike = tuple(Dispersion((key,), "log_normal", ((0.1,),)) for key in (first, second))
    both = dataclasses.replace(wide, dispersions=alike, values={first: 1.0, second: 1.0})
    drawn = draw(both, 3, RUNS)[0]
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 5.0 / np.sqrt(len(RUNS))


def test_a_value_that_makes_no_sense_is_refused_before_anything_flies(wide):
    bad = (Dispersion(("wheel.b.coulomb",), "normal", ((7e-6,),)),)
    with pytest.raises(InputError, match=r"dispersion of wheel\.b\.coulomb: found -.* in run \d+"):
        check_draws(dataclasses.replace(wide, dispersions=bad), 0, 5000)
    flat = (Dispersion(("body.inertia.zz",), "uniform", ((0.1, 0.5),)),)
    with pytest.raises(InputError, match=r"dispersion of body\.inertia\.zz: in run \d+, body"):
        check_draws(dataclasses.replace(wide, dispersions=flat), 0, 50)
    late = (Dispersion(("event.loss.time",), "uniform", ((6.0, 20.0),)),)
    with pytest.raises(InputError, match=r"in run \d+, event\.\w+: found events in another order"):
        check_draws(dataclasses.replace(wide, dispersions=late), 0, 50)
    # an event after the end of the run does not happen
    never = (Dispersion(("event.loss.time",), "uniform", ((1e4, 2e4),)),)
    alone = dataclasses.replace(wide, events=wide.events[:1], dispersions=never)
    check_draws(alone, 0, 50)
    check_draws(wide, 3, 50)


def test_sensor_faults_and_limits_without_extent_are_refused_before_anything_flies(scenario):
    """The bounds of each are drawn apart, so that each value alone makes sense."""
    event = Event("gap", "sensor_dropout", sensor="rate", element=None)
    fault = {f"event.gap.{k}": v for k, v in {"time": 3.0, "until": 5.0, "share": 1.0}.items()}
    limits = {f"guard.{name}": key.default for name, key in GUARD.items()}
    limits |= {"guard.rate_lower": -0.1, "guard.rate_upper": 0.1}

    def spread(key, low, high):
        return dataclasses.replace(
            scenario,
            events=(*scenario.events, event),
            guard="hold",
            values={**scenario.values, **fault, **limits},
            dispersions=(Dispersion((key,), "uniform", ((low, high),)),),
        )

    with pytest.raises(
        InputError, match=r"event\.gap\.until: found [\d.]+ s, expected a time after its start, 3 s"
    ):
        check_draws(spread("event.gap.until", 1.0, 5.0), 0, 50)
    with pytest.raises(
        InputError,
        match=r"guard\.rate_upper: found -0.*, expected more than guard\.rate_lower, -0\.1",
    ):
        check_draws(spread("guard.rate_upper", -0.2, 0.2), 0, 50)
    check_draws(spread("guard.rate_upper", 0.0, 0.2), 0, 50)
