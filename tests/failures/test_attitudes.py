"""Attitudes by NumPy against SciPy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.failures.attitudes import matrix_of, turned


def test_matrices_and_turns_are_those_of_scipy():
    random = np.random.default_rng(0)
    for quaternion, axis, angle in zip(
        random.standard_normal((50, 4)),
        random.standard_normal((50, 3)),
        random.uniform(-7.0, 7.0, 50),
        strict=True,
    ):
        there, unit = Rotation.from_quat(quaternion, scalar_first=True), axis / np.linalg.norm(axis)
        np.testing.assert_allclose(matrix_of(quaternion), there.as_matrix(), atol=1e-15)
        after = there * Rotation.from_rotvec(angle * unit)
        np.testing.assert_allclose(
            turned(quaternion, unit, angle),
            after.as_quat(canonical=True, scalar_first=True),
            atol=1e-15,
        )


@pytest.mark.parametrize("axis", np.eye(3))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_half_a_turn_has_one_quaternion(axis, sign):
    start = np.array([0.0, *-axis])
    found = turned(start, sign * axis, 0.0)
    np.testing.assert_array_equal(found, [0.0, *axis])
    assert not np.any(np.signbit(found))
