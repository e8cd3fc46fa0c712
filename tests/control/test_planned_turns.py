"""Planned rotations as data of a reference: against differentiation, and where a plan is left."""

from functools import partial

import numpy as np
import pytest

from gyrostat.control.guidance import (
    AttitudeReference,
    PlannedTurns,
    SlewLimits,
    SlewProfile,
    Slews,
    Transition,
    Turn,
    reference_at,
)
from gyrostat.control.guidance.bowed_path import BowedPath
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp

LIMITS = SlewLimits(rate=0.05, acceleration=0.01, jerk=0.005)
PROFILE = SlewProfile.fastest(1.0, 0.02, 1e-3, 1e-3)
TURN = np.array([0.3, 1.1, -0.4])
BOWS = np.array([[0.4, -0.2, 0.1], [0.05, 0.1, -0.2]])
PLAN = PlannedTurns.none(3).planned(1, Turn(jnp.asarray(TURN), jnp.asarray(BOWS), PROFILE))
START = np.array([0.5, 0.5, -0.5, 0.5])
END = np.asarray(rotations.product(jnp.asarray(START), rotations.from_rotation_vector(TURN)))


def spinning(time):
    """Attitude at a constant rate of 2 mrad/s."""
    turned = rotations.from_rotation_vector(time * jnp.array([1e-3, -1e-3, 1.4e-3]))
    return rotations.product(jnp.asarray(END), turned)


def test_motion_of_a_path_is_its_derivative():
    path = BowedPath.eigenaxis(jnp.asarray(START), jnp.asarray(TURN))
    path = path._replace(bow=jnp.asarray(BOWS[0]), twist=jnp.asarray(BOWS[1]))

    def progress(time):
        return 0.2 + 0.3 * time - 0.1 * time**2

    found = path.motion(progress(0.7), 0.3 - 0.2 * 0.7, -0.2)
    expected = reference_at(lambda time: path(progress(time)), 0.7)
    for one, other in zip(found, expected, strict=True):
        assert one == pytest.approx(np.asarray(other), abs=1e-13)


@pytest.fixture(scope="module")
def transition():
    before = AttitudeReference(jnp.asarray(START), jnp.array([2e-3, 0, 1e-3]), jnp.zeros(3))
    return Transition.of(before, reference_at(spinning, 0.0), 0.0, LIMITS, partial(PLAN.fitted, 1))


def test_transition_along_a_planned_path_moves_as_its_attitude(transition):
    """From the motion before, along the bows, to a target that turns."""

    def attitude(time):
        return transition(time, reference_at(spinning, time)).attitude

    times = np.linspace(0.0, float(transition.duration), 9)
    follow = jax.jit(jax.vmap(lambda time: transition(time, reference_at(spinning, time))))
    found = follow(times)
    differentiate = jax.jit(jax.vmap(lambda time: reference_at(attitude, time)))
    expected = differentiate(times[1:-1])
    for one, other in zip(found, expected, strict=True):
        assert one[1:-1] == pytest.approx(np.asarray(other), abs=1e-11)
    assert np.linalg.norm(transition.bows) == pytest.approx(np.linalg.norm(BOWS), rel=1e-12)
    for row, wanted in ((0, START), (-1, np.asarray(spinning(times[-1])))):
        assert rotations.error_angle(found.attitude[row], jnp.asarray(wanted)) < 1e-7
    assert found.rate[0] == pytest.approx([2e-3, 0, 1e-3], abs=1e-12)


def test_slews_follow_their_planned_path():
    other = [0.0, 0.6, 0.0, 0.8]
    slews = Slews.to(other, [0.0, 300.0], [START, END], LIMITS, PlannedTurns(*PLAN))
    path = BowedPath.eigenaxis(jnp.asarray(START), jnp.asarray(TURN))
    path = path._replace(bow=jnp.asarray(BOWS[0]), twist=jnp.asarray(BOWS[1]))
    for since in (10.0, 30.0, 1e3):
        expected = path(PROFILE(since))
        assert rotations.error_angle(slews(300.0 + since), expected) < 1e-7
    assert slews.ends()[1] == pytest.approx(300.0 + float(PROFILE.duration))
    # without a plan, about the eigenaxis
    alone = Slews.to(other, [0.0], [START], LIMITS)
    assert np.asarray(slews(20.0)) == pytest.approx(np.asarray(alone(20.0)), abs=1e-14)


@pytest.mark.parametrize(
    ("row", "turn", "fits"),
    [
        (1, TURN, True),
        (0, TURN, False),
        (1, TURN + np.array([0.09, 0, 0]), True),
        (1, TURN + np.array([0.11, 0, 0]), False),
        (1, np.zeros(3), False),
    ],
)
def test_a_rotation_far_from_its_plan_turns_about_its_eigenaxis(row, turn, fits):
    eigenaxis = SlewProfile.fastest(2.0, 0.02, 1e-3, 1e-3)
    found = PLAN.fitted(row, jnp.asarray(turn), eigenaxis)
    assert np.asarray(found.turn) == pytest.approx(np.asarray(turn))
    assert np.asarray(found.bows) == pytest.approx(BOWS if fits else np.zeros((2, 3)))
    assert found.profile.duration == (PROFILE if fits else eigenaxis).duration


def test_an_offset_of_the_start_moves_the_path_by_its_own_size_at_most():
    rng, moved = np.random.default_rng(5), []

    def attitude(turn, share):
        path = BowedPath.eigenaxis(jnp.array([1.0, 0, 0, 0]), turn)
        path = path._replace(bow=jnp.asarray(BOWS[0]), twist=jnp.asarray(BOWS[1]))
        end = rotations.conjugate(path(1.0))
        return rotations.product(end, path(share))  # in axes of the end

    for _ in range(20):
        offset = rng.normal(size=3) * 0.03
        other = jnp.asarray(TURN + offset)
        paths = [jax.vmap(partial(attitude, turn))(np.linspace(0, 1, 21)) for turn in (TURN, other)]
        angles = jax.vmap(rotations.error_angle)(*paths)
        moved.append(np.max(angles) / np.linalg.norm(offset))
    assert 0.9 < np.max(moved) <= 1.0


def test_the_longer_way_of_a_plan_is_taken():
    """Of a rotation near half a turn, which of both ways is the shortest one can change."""
    axis = np.array([0.6, 0.0, 0.8])
    longer = Turn(jnp.asarray(-3.18 * axis), jnp.asarray(BOWS), PROFILE)
    plan = PlannedTurns.none(1).planned(0, longer)
    for angle in (2.0 * np.pi - 3.18, 2.0 * np.pi - 3.25, -3.13):
        found = plan.fitted(0, jnp.asarray(angle * axis), PROFILE)
        assert np.asarray(found.bows) == pytest.approx(BOWS)
        expected = angle if angle < 0.0 else angle - 2.0 * np.pi
        assert np.asarray(found.turn) == pytest.approx(expected * axis)


@pytest.mark.parametrize(
    ("offset", "rate", "acceleration", "fits"),
    [
        (0.0, 0.0, 0.0, True),
        (0.02, 0.99, 0.0, True),
        (0.021, 0.0, 0.0, False),
        (0.0, 1.01, 0.0, False),
        (0.0, 0.0, 0.99, True),
        (0.0, 0.0, 1.01, False),
        (np.nan, 0.0, 0.0, False),
        (0.0, np.nan, 0.0, False),
    ],
)
def test_a_start_that_the_cones_are_not_widened_for_does_not_fit(offset, rate, acceleration, fits):
    """The bounds of the motion beside a path, from the largest values of its shares in time."""
    x, duration = np.linspace(0.0, 1.0, 100001), float(PROFILE.duration)
    by_rate = np.max(x * (1.0 - x) ** 3 * (1.0 + 3.0 * x)) * duration
    by_acceleration = np.max(0.5 * x**2 * (1.0 - x) ** 3) * duration**2
    motion = 0.03 * rate / by_rate, 0.03 * acceleration / by_acceleration
    plan = Turn(jnp.asarray(TURN), jnp.asarray(BOWS), PROFILE)
    covered = PlannedTurns.none(3, covered=True).planned(1, plan, (0.02, 0.03))
    turn = jnp.asarray(TURN + np.array([offset, 0.0, 0.0]))
    assert bool(covered.fits(1, turn, motion)) == fits
    assert (covered.fitted(1, turn, PROFILE, motion).bows == BOWS).all() == fits
