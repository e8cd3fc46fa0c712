"""Thrusters against force times arm, impulse bits and the rocket equation."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft import Thrusters

PERIOD, FORCE, ARM = 0.5, 0.02, 0.3
REST = np.array([1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("pair", range(6))
def test_a_pair_gives_a_couple_about_its_axis(pair):
    thrusters = Thrusters.couples(ARM, FORCE, PERIOD)
    thrusters.check()
    value = np.zeros(12)
    value[2 * pair : 2 * pair + 2] = 0.1
    expected = np.zeros(3)
    expected[pair // 2] = (-1.0) ** pair * 2.0 * FORCE * ARM * 0.1 / PERIOD
    np.testing.assert_allclose(thrusters(value, REST, 0.0), expected, atol=1e-18)
    np.testing.assert_allclose(value @ np.asarray(thrusters.directions), 0.0, atol=1e-18)


def test_the_torque_is_arm_cross_force_for_any_layout():
    draw = np.random.default_rng(3)
    places, along = draw.normal(size=(2, 5, 3))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    force = draw.uniform(0.01, 0.1, 5)
    value = draw.uniform(0.0, PERIOD, 5)
    found = Thrusters(places, along, force, PERIOD)(value, REST, 0.0)
    each = [
        np.cross(r, f * d * t / PERIOD)
        for r, d, f, t in zip(places, along, force, value, strict=True)
    ]
    np.testing.assert_allclose(found, np.sum(each, axis=0), rtol=1e-12)


def test_commands_below_the_impulse_bit_do_nothing_and_long_ones_are_limited():
    thrusters = Thrusters.couples(ARM, FORCE, PERIOD, minimum=0.02)
    value = np.array([0.0199, 0.02, 0.1, 0.5, 0.7, -0.1, *np.zeros(6)])
    expected = [0.0, 0.02, 0.1, 0.5, 0.5, 0.0, *np.zeros(6)]
    np.testing.assert_allclose(thrusters.on_time(value), expected, rtol=1e-15)


def test_the_propellant_is_that_of_the_rocket_equation():
    """A small impulse: dv = g_0 I_sp ln(m / (m - dm)) is F t / m."""
    thrusters = Thrusters.couples(ARM, FORCE, PERIOD, specific_impulse=60.0)
    used = float(thrusters.propellant(np.array([0.5, *np.zeros(11)])))
    mass = 1e3
    assert FORCE * 0.5 / mass == pytest.approx(-9.80665 * 60.0 * np.log1p(-used / mass), rel=1e-6)


def test_bad_thrusters_are_refused():
    for options, message in (
        ({"force": 0.0}, "thrust: found 0"),
        ({"directions": 2.0 * np.eye(3)}, "directions of the thrusters"),
        ({"positions": np.zeros((2, 3))}, r"positions of shape \(2, 3\)"),
        ({"minimum": -1.0}, "minimum on-time: found -1"),
    ):
        given = {"positions": np.eye(3), "directions": np.eye(3), "force": 1.0, "period": 1.0}
        with pytest.raises(InputError, match=message):
            Thrusters(**{**given, **options}).check()
    with pytest.raises(InputError, match=r"thrusters: found a command of shape \(3,\)"):
        Thrusters.couples(ARM, FORCE, PERIOD)(np.zeros(3), REST, 0.0)
