"""Bands of each set of failed wheels, and the nearest direction on them, compiled and not."""

import numpy as np
import pytest

from gyrostat.codegen.numpy_tracing import with_jax
from gyrostat.codegen.simd.batch import lanes
from gyrostat.core.directions import spread_evenly
from gyrostat.failures import holdable
from gyrostat.failures.attitudes import matrix_of, quaternion_of
from gyrostat.failures.held_bands import held_bands, nearest_on_bands, padded
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

AXES = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
BODY, KEPT = np.array([0.6, 0.0, 0.8]), {1: 0.02}


@pytest.fixture(scope="module")
def spacecraft():
    axes = AXES / np.linalg.norm(AXES, axis=0)
    friction = ViscousCoulomb(viscous=1e-6, coulomb=1e-4)
    wheels = WheelArray(
        axes=axes, inertia=1e-4, friction=friction, torque_limit=0.01, momentum_limit=0.05
    )
    return Spacecraft(inertia=np.diag([0.2, 0.3, 0.25]), wheels=wheels)


def test_nearest_direction_is_that_of_the_query_for_each_set(spacecraft):
    """Same numbers as `holdable`, for momenta and targets all over the sky, in Python and in C."""
    directions = spread_evenly(9)
    radius = 0.045
    rows, expected = [], []
    for held in held_bands(spacecraft, radius * directions[0], KEPT, BODY):
        failed = {k: KEPT.get(k, 0.0) for k in held.failed}
        assert (held.reason is None) == (len(held.sky.bands) > 0)
        for momentum, wanted in zip(radius * directions[:4], directions[4:], strict=False):
            answer = holdable(spacecraft, momentum, failed=failed, boresight=(BODY, wanted))
            assert answer.reason == held.reason
            if held.reason is None:
                rows.append((BODY, momentum, wanted, *padded(held)))
                expected.append(answer)
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    compiled = lanes(with_jax(nearest_on_bands), (True,) * 5, columns)(*columns)
    for k, answer in enumerate(expected):
        python = nearest_on_bands(*rows[k])
        for number in (python, [each[k] for each in compiled]):
            is_held, away, direction, attitude = number
            assert bool(is_held) == answer.holdable
            np.testing.assert_allclose(away, answer.angle, atol=1e-9)
            np.testing.assert_allclose(direction, answer.direction, atol=1e-9)
            if not answer.holdable:
                np.testing.assert_allclose(attitude, answer.attitude, atol=1e-9)
    assert 5 < sum(answer.holdable for answer in expected) < len(expected) - 5


@pytest.mark.parametrize("scalar", [0.0, 1e-9, 0.3, 1.0])
def test_quaternion_of_a_matrix_is_that_of_the_rotation(scalar):
    axis = np.array([-0.48, 0.6, -0.64])
    quaternion = np.array([scalar, *(np.sqrt(1.0 - scalar**2) * axis)])
    found = quaternion_of(matrix_of(quaternion))
    sign = 1.0 if scalar > 0.0 else -1.0  # then the first of the others is positive
    np.testing.assert_allclose(found, sign * quaternion, atol=1e-12)
