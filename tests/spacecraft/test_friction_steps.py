"""Friction steps: which are refused, and when they count; flights are in the tests of campaigns."""

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft import FrictionSteps, Gyrostat, Spacecraft
from gyrostat.wheel import WheelArray, pyramid_axes
from gyrostat.wheel.friction import Stribeck, ViscousCoulomb

BEFORE = ViscousCoulomb(viscous=1e-7, coulomb=np.full(4, 2e-5))
AFTER = ViscousCoulomb(viscous=np.full(4, 3e-7), coulomb=np.full(4, 9e-5))
CRAFT = Spacecraft(0.1 * np.eye(3), WheelArray(pyramid_axes(4), np.full(4, 2e-5), friction=BEFORE))
TIME = np.array([np.inf, 5.0, 0.0, np.inf])


@pytest.mark.parametrize(("now", "done"), [(0.0, [0, 0, 1, 0]), (5.0, [0, 1, 1, 0])])
def test_each_wheel_has_its_new_friction_from_its_time_on(now, done):
    found = FrictionSteps(TIME, AFTER).at(now, BEFORE)
    np.testing.assert_array_equal(found.coulomb, np.where(done, 9e-5, 2e-5))
    np.testing.assert_array_equal(found.viscous, np.where(done, 3e-7, 1e-7))


@pytest.mark.parametrize(("now", "share"), [(4.0, 0.0), (5.0, 0.0), (7.5, 0.25), (15.0, 1.0)])
def test_friction_can_rise_linearly(now, share):
    """Over 10 s from 5 s on; a wheel with a step and one without any are as they were."""
    time, length = np.array([5.0, 5.0, 0.0, np.inf]), np.array([10.0, 10.0, 0.0, 10.0])
    found = FrictionSteps(time, AFTER, length).at(now, BEFORE)
    expected = np.array([share, share, 1.0, 0.0])
    np.testing.assert_allclose(found.coulomb, 2e-5 + expected * 7e-5, rtol=1e-14)
    np.testing.assert_allclose(found.viscous, 1e-7 + expected * 2e-7, rtol=1e-14)


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (FrictionSteps(-TIME, AFTER), "found -inf s, expected 0 s"),
        (FrictionSteps(TIME + np.nan, AFTER), "found nan s, expected 0 s"),
        (FrictionSteps(TIME, AFTER, -1.0), "duration of a friction step: found -1"),
        (FrictionSteps(TIME[:3], AFTER), r"shape \(3,\), expected \(4,\)"),
        (FrictionSteps(TIME, ViscousCoulomb.of(viscous=-1.0, coulomb=0.0)), "viscous: found -1"),
        (FrictionSteps(TIME, Stribeck(0.0, 0.0, 0.0, 1.0)), "found stribeck friction, expected"),
    ],
)
def test_steps_that_are_none_are_refused(steps, message):
    with pytest.raises(InputError, match=message):
        Gyrostat(CRAFT, friction_steps=steps).check()
