"""What no spacecraft is."""

import dataclasses

import numpy as np
import pytest

from gyrostat.core.errors import InputError
from gyrostat.spacecraft import Spacecraft, check_inertia
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import LuGre, Stribeck

WHEELS = WheelArray(axes=np.eye(3), inertia=np.full(3, 1e-3))
BODY = Spacecraft(inertia=np.diag([8.0, 12.0, 16.0]), wheels=WHEELS)


def test_a_plain_spacecraft_is_taken():
    BODY.check()
    np.testing.assert_allclose(BODY.inertia_locked(), BODY.inertia + 1e-3 * np.eye(3))


@pytest.mark.parametrize(
    ("inertia", "found"),
    [
        (np.diag([1.0, 1.0]), r"shape \(2, 2\)"),
        (np.diag([1.0, 1.0, np.nan]), "not finite"),
        (np.diag([1.0, 1.0, 0.0]), "principal inertia 0"),
        (np.diag([1.0, -1.0, 1.0]), "principal inertia -1"),
        (np.diag([1.0, 1.0, 2.1]), "1, 1, 2.1"),
        ([[2.0, 0.1, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]], "not symmetric"),
    ],
)
def test_what_is_no_inertia(inertia, found):
    with pytest.raises(InputError, match=found):
        check_inertia(np.asarray(inertia))


def test_a_flat_plate_is_a_body():
    check_inertia(np.diag([1.0, 2.0, 3.0]))


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"axes": 2.0 * np.eye(3)}, "length of 2"),
        ({"axes": np.ones(3)}, "shape"),
        ({"axes": np.full((3, 1), np.nan)}, "length of nan"),
        ({"inertia": np.array([1e-3, 0.0, 1e-3])}, "wheel inertia: found 0"),
        ({"inertia": np.full(2, 1e-3)}, "found 2 values, expected 3"),
        ({"torque_limit": 0.0}, "torque_limit"),
        ({"torque_limit": np.ones(2)}, "torque_limit: found 2 values, expected 3"),
        ({"momentum_limit": np.ones(4)}, "momentum_limit: found 4 values, expected 3"),
        ({"momentum_limit": np.nan}, "momentum_limit: found nan"),
        ({"momentum_limit": np.array([1.0, -1.0, 1.0])}, "momentum_limit"),
        ({"friction": 3.0}, "found float"),
        ({"friction": Stribeck(0.0, np.zeros(2), np.zeros(2), 1.0)}, "coulomb: found 2 values"),
        ({"friction": LuGre.dahl(np.ones(2), 1.0)}, "coulomb: found 2 values"),
        ({"friction": LuGre.dahl(1.0, np.ones(2))}, "stiffness: found 2 values"),
    ],
)
def test_what_are_no_wheels(change, found):
    wheels = dataclasses.replace(WHEELS, **change)
    with pytest.raises(InputError, match=found):
        Spacecraft(BODY.inertia, wheels).check()


def test_lists_are_numbers_too():
    wheels = WheelArray(np.eye(3).tolist(), [1e-3] * 3, [0.1] * 3, [3.0] * 3)
    craft = Spacecraft(BODY.inertia.tolist(), wheels)
    craft.check()
    np.testing.assert_allclose(craft.inertia_locked(), BODY.inertia_locked())
    torque = wheels.within_torque_limit(np.array([1.0, -1.0, 0.05]))
    np.testing.assert_allclose(torque, [0.1, -0.1, 0.05])


@pytest.mark.parametrize("inertia", [[[1.0, 0.0], [1.0]], ["one", "two"]])
def test_lists_that_are_no_numbers(inertia):
    with pytest.raises(InputError, match="expected numbers, in rows of one length"):
        Spacecraft(inertia, WHEELS)


def test_momentum_limit():
    """Up to the limit within the time, and no brake beyond it."""
    wheels = dataclasses.replace(WHEELS, momentum_limit=3.0)
    given = wheels.within_momentum_limit(np.ones(3), np.array([2.9, 3.5, -3.5]), 0.5)
    np.testing.assert_allclose(given, [0.2, 0.0, 1.0])
    given = wheels.within_momentum_limit(np.zeros(3), np.array([3.5, -3.5, 0.0]), 0.5)
    np.testing.assert_allclose(given, np.zeros(3))


@pytest.mark.parametrize("torque", [1.0, np.ones(2), np.ones((1, 3))])
def test_a_torque_that_is_not_one_a_wheel(torque):
    with pytest.raises(InputError, match=r"wheel torque: found shape .*expected \(3,\)"):
        WHEELS.within_torque_limit(torque)
