"""Pointing profiles along an orbit, against the geometry that they stand for."""

from dataclasses import fields
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control.guidance import GroundTarget, Nadir, Pointing, reference_at, to_earth, to_sun
from gyrostat.control.guidance.attitude_reference import Motion
from gyrostat.core import rotations
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import CircularOrbit
from tests.spacecraft import orbit_samples

ORBIT = orbit_samples.environment()
TARGET = GroundTarget(0.4, 0.8, 100.0)
AXIS, SECOND = np.array([0.1, -0.2, 2.0]), np.array([1.0, 0.3, 0.0])


def rotation(quaternion):
    return Rotation.from_quat(np.array(quaternion), scalar_first=True)


@pytest.mark.parametrize("aim", [to_earth, to_sun, TARGET])
def test_axis_points_and_second_axis_is_as_near_as_possible(aim):
    profile = Pointing.of(ORBIT, aim, AXIS, SECOND)
    profile.check()
    axes_and_attitude = jax.jit(lambda time: (aim(ORBIT, time), profile(time)))
    for time in (0.0, 500.0, 3333.3):
        (first, second), attitude = axes_and_attitude(time)
        to_body = rotation(attitude).inv()
        seen = to_body.apply(np.array(first))
        np.testing.assert_allclose(
            seen / np.linalg.norm(seen), AXIS / np.linalg.norm(AXIS), atol=1e-14
        )
        # in the plane of both axes, on the side of the second
        other = to_body.apply(np.array(second))
        assert abs(other @ np.cross(AXIS, SECOND)) < 1e-12 * np.linalg.norm(other)
        assert other @ (SECOND - (SECOND @ AXIS) / (AXIS @ AXIS) * AXIS) > 0.0


def test_nadir_is_that_of_the_circular_orbit():
    circle = CircularOrbit(orbit_samples.RATE, inclination=orbit_samples.INCLINATION)
    axes = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]
    one, other = Nadir.pointing(circle, *axes), Pointing.of(ORBIT, to_earth, *axes)
    true_at, found_at = (jax.jit(partial(reference_at, profile)) for profile in (one, other))
    for time in (100.0, 4000.0):
        found, true = found_at(time), true_at(time)
        apart = rotation(true.attitude).inv() * rotation(found.attitude)
        assert apart.magnitude() < 1e-8
        np.testing.assert_allclose(found.rate, true.rate, atol=1e-9)
        np.testing.assert_allclose(found.acceleration, true.acceleration, atol=1e-8)


def test_rate_toward_a_ground_target_is_that_of_the_line_of_sight():
    """The rate across the line of sight is |r x v| / r² of the relative motion."""
    profile = Pointing.of(ORBIT, TARGET, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])

    @jax.jit
    def sight_and_rate(time):
        sight = jax.jvp(lambda time: TARGET(ORBIT, time)[0], (time,), (1.0,))
        return *sight, reference_at(profile, time).rate

    for time in (50.0, 2500.0):
        line, slope, found = map(np.asarray, sight_and_rate(time))
        across = np.linalg.norm(np.cross(line, slope)) / (line @ line)
        assert np.hypot(found[0], found[1]) == pytest.approx(float(across), rel=1e-9)


@pytest.mark.parametrize("aim", [to_sun, TARGET])
def test_the_reference_is_the_motion_of_the_attitude(aim):
    """The derivatives of the directions give those of the attitude, by the chain rule."""
    profile = Pointing.of(ORBIT, aim, AXIS, SECOND)

    @jax.jit
    def both(time):
        return reference_at(profile, time), Motion.of(profile, time).reference

    for time in (40.0, 2100.0, 5555.5):
        found, expected = both(time)
        for ours, theirs in zip(found, expected, strict=True):
            assert np.max(np.abs(ours - theirs)) < 1e-12 * np.max(np.abs(theirs))


def test_a_profile_is_a_tree_of_numbers():
    for aim in (to_earth, TARGET):
        leaves = jax.tree.leaves(Pointing.of(ORBIT, aim, AXIS, SECOND))
        assert all(np.issubdtype(np.asarray(leaf).dtype, np.number) for leaf in leaves)


def test_parallel_axes_are_refused():
    with pytest.raises(InputError, match="parallel"):
        Pointing.of(ORBIT, to_sun, [1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]).check()


class Turned(Pointing):
    """Pointing with an attitude of its own."""

    def __call__(self, time):
        return rotations.product(super().__call__(time), jnp.array([0.6, 0.8, 0.0, 0.0]))


class Wrapped(NamedTuple):
    """Profile with a field that has the name of a method of others."""

    reference: Any

    def __call__(self, time):
        return self.reference(time)


def test_a_profile_of_a_user_gives_its_own_attitude():
    shipped = Pointing.of(ORBIT, TARGET, AXIS, SECOND)
    own = Turned(*(getattr(shipped, each.name) for each in fields(shipped)))
    for profile in (own, Wrapped(own), Wrapped(shipped)):
        found = reference_at(profile, 40.0)
        for ours, theirs in zip(found, Motion.of(profile, 40.0).reference, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-18)
