"""Ways around cones from random starts: rotations, angles and bodies apart from gyrostat."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turned

from gyrostat.codegen.flight import Entry, emit
from gyrostat.control.guidance import SlewLimits
from gyrostat.control.guidance.bodies import NO_BODY, Bodies, Sky
from gyrostat.control.guidance.way_around import PARTS, Start, way_around
from gyrostat.core import rotations
from gyrostat.core.jax64 import jax, jnp

pytestmark = pytest.mark.optimised
LIMITS = SlewLimits(rate=0.01, acceleration=5e-4)
CASES = 300
BORESIGHTS = np.array([[0.0, 0.0, 1.0], [0.0, 2.0, -1.0]]) / [[1.0], [np.sqrt(5.0)]]
SPIN = 1e-3
"""Rate at which the bodies turn about z in axes of the target, rad/s."""
SETS = np.array([[[35, 0], [0, 0]], [[120, 0], [0, 0]], [[35, 15], [50, 0]]])
"""Angles of each instrument to each body, deg, in three sets of random cases."""
SWAY = np.radians(8.0)


class Case(NamedTuple):
    """Start relative to the target, bodies, cones, and how the bodies turn.

    They turn by spin t - sway sin²(pi t / part) about an axis.
    """

    offset: Any
    directions: Any
    angles: Any
    axis: Any
    spin: Any
    sway: Any
    part: Any


def way_of(*values):
    """Way from an attitude relative to the target."""
    case = Case(*values)

    def at(time):
        angle = case.spin * time - case.sway * jnp.sin(jnp.pi * time / case.part) ** 2
        turn = rotations.from_rotation_vector(angle * case.axis)
        return Sky(jax.vmap(rotations.to_inertial, (None, 0))(turn, case.directions), case.angles)

    def profile(turn, offset, time):
        return LIMITS.profile(turn, offset, time)

    return way_around(
        Start(case.offset, jnp.zeros(()), profile, 0.01, 0.01), Bodies(jnp.asarray(BORESIGHTS), at)
    )


def random_cases():
    """Random starts and bodies, the same for each set of angles."""
    rng = np.random.default_rng(4)
    offset = Turned.random(CASES, rng=rng).as_quat(canonical=True, scalar_first=True)
    directions = rng.normal(size=(CASES, 2, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    angles = np.repeat(np.where(SETS > 0, np.radians(SETS), NO_BODY), CASES, axis=0)
    count = CASES * len(SETS)
    axis = np.tile([0.0, 0.0, 1.0], (count, 1))
    directions = np.tile(directions, (len(SETS), 1, 1))
    motion = np.array([[SPIN], [0.0], [1.0]]) * np.ones(count)
    return Case(np.tile(offset, (len(SETS), 1)), directions, angles, axis, *motion)


def swaying_cases():
    """A body that rests, and one at the same place at the ends of all parts, nearer between them.

    It is 39 deg beside the middle of a turn by 120 deg; in its sway, 31 deg, by 35 deg of the cone.
    """
    turn = np.array([np.radians(120.0), 0.0, 0.0])
    part = float(LIMITS.profile(turn, np.eye(4)[0], 0.0).duration) / PARTS
    middle = Turned.from_rotvec(0.5 * turn).apply([0.0, 0.0, 1.0])
    across = np.array([1.0, 0.0, 0.0])
    angle = np.radians(39.0)
    directions = np.stack([np.cos(angle) * middle + np.sin(angle) * across, across])
    angles = np.array([[np.radians(35.0), NO_BODY], [NO_BODY, NO_BODY]])
    offset = Turned.from_rotvec(turn).as_quat(scalar_first=True)
    each = [offset, directions, angles, np.cross(middle, across), 0.0]
    return Case(*map(np.stack, zip(*[(*each, sway, part) for sway in (0.0, SWAY)], strict=True)))


@pytest.fixture(scope="module")
def every():
    """All cases and their ways, of one compiled function."""
    cases = Case(*map(np.concatenate, zip(random_cases(), swaying_cases(), strict=True)))
    return cases, jax.tree.map(np.asarray, jax.jit(jax.vmap(way_of))(*cases))


@pytest.fixture(scope="module")
def flown(every):
    """Ways of the random cases, and angles beyond the cones along them; leading axis of sets."""
    cases, way = jax.tree.map(lambda each: each[: CASES * len(SETS)], every)
    rows = [*along(way, np.linspace(0.0, 1.0, 41))]
    offset = Turned.from_quat(cases.offset, scalar_first=True)
    assert np.max((rows[0][0].inv() * offset).magnitude()) < 1e-9
    assert np.max(rows[-1][0].magnitude()) < 1e-9
    beyond = np.array([apart(turned, *cases[1:3], time) for turned, time in rows])
    way = jax.tree.map(lambda each: each.reshape(len(SETS), CASES, *each.shape[1:]), way)
    return way, beyond.reshape(len(rows), len(SETS), CASES)


def along(way, shares):
    """Attitudes relative to the target, and times, in each of three rotations one after another."""
    turns = np.concatenate([way.turns, way.last[:, None]], axis=1)
    profiles = jax.tree.map(
        lambda before, last: np.concatenate([before, last[:, None]], axis=1),
        way.profiles,
        way.profile,
    )
    ends = np.cumsum(profiles.duration, axis=1)
    for stage in range(3):
        for share in shares:
            since = share * profiles.duration[:, stage]
            each = jax.tree.map(lambda x, stage=stage: x[:, stage], profiles)
            left = 1.0 - np.asarray(jax.vmap(lambda p, t: p.progress(t))(each, since))
            rotated = Turned.identity(len(turns))
            for k in (2, 1, 0):
                part = left if k == stage else np.full(len(turns), float(k > stage))
                rotated *= Turned.from_rotvec(part[:, None] * turns[:, k])
            yield rotated, ends[:, stage] - profiles.duration[:, stage] + since


def apart(rotated, directions, angles, time):
    """Least angle of any boresight beyond that of its cone, rad."""
    turn = Turned.from_rotvec((SPIN * time)[:, None] * np.array([0.0, 0.0, 1.0]))
    least = np.full(len(time), np.inf)
    for instrument, boresight in enumerate(BORESIGHTS):
        sight = rotated.apply(boresight)
        for body in range(directions.shape[1]):
            toward = turn.apply(directions[:, body])
            cosine = np.clip(np.sum(sight * toward, axis=1), -1.0, 1.0)
            beyond = np.arccos(cosine) - angles[:, instrument, body]
            counts = angles[:, instrument, body] > 0.0
            least = np.where(counts, np.minimum(least, beyond), least)
    return least


@pytest.mark.parametrize("number", range(len(SETS)))
def test_no_way_enters_a_cone_without_a_word(flown, number):
    way, beyond = jax.tree.map(lambda each: each[number], flown[0]), flown[1][:, number]
    outside, clear = beyond[0] > 0.0, beyond[-1] > 0.08
    assert np.min(beyond[:, way.blocked == 0.0]) > 0.0
    assert np.all(way.blocked[~outside] >= 2.0)
    free = outside & clear
    # a target that bodies turn past may be blocked in time; of one cone that rests, none is
    assert np.mean(way.blocked[free] == 0.0) > (0.95 if number == 1 else 0.99)
    detours = free & (np.linalg.norm(way.turns[:, 1], axis=1) > 1e-6)
    assert np.count_nonzero(detours) >= 2


def test_a_turn_that_starts_inside_leaves_by_the_shortest_way_and_says_so(flown):
    way, beyond = jax.tree.map(lambda each: each[0], flown[0]), flown[1][:, 0]
    inside = (beyond[0] < 0.0) & (beyond[-1] > 0.08)
    assert np.count_nonzero(inside) > 10
    assert np.all(way.blocked[inside] == 2.0)
    depth = -beyond[0, inside]
    leaving = np.linalg.norm(way.turns[inside, 0], axis=1)
    # straight away from the body: the depth, the margin, and the way of the body meanwhile
    assert np.all(leaving >= depth + 0.01)
    assert np.all(leaving <= depth + 0.01 + 0.2)
    after = beyond[:, inside]
    left = np.argmax(after > 0.0, axis=0)
    for column, first in zip(after.T, left, strict=True):
        # while the turn is slow, the body may come nearer by its own motion
        assert np.all(np.diff(column[: first + 1]) > -2e-3)
        assert np.all(column[first:] > 0.0)


def test_a_body_that_sways_within_a_part_is_not_passed_without_a_word(every):
    _, way = every
    assert way.blocked[-2:].tolist() == [0.0, 1.0]
    # about the eigenaxis, which is clear at the ends of all parts
    np.testing.assert_allclose(way.turns[-2:], 0.0, atol=1e-12)


def test_generated_c_finds_the_same_ways(every, tools, tmp_path):
    """Ties between waypoints are broken by rounding, which leaves the duration the same."""

    def flat(offset, directions, angles, axis, spin, sway, part):
        way = way_of(offset, directions, angles, axis, spin, sway, part)
        before = way.profiles.duration
        return way.blocked, before[0] + before[1] + way.profile.duration, way.turns, way.last

    cases, way = every
    given = {name: np.zeros(each.shape[1:]) for name, each in cases._asdict().items()}
    entry = Entry("way", flat, given, ("blocked", "duration", "turns", "last"))
    compiled = tools.Compiled(emit("around", [entry]), tmp_path)
    status, found = compiled("way", cases._asdict())
    assert not status.any()
    np.testing.assert_array_equal(found["blocked"][0], way.blocked)
    duration = np.sum(way.profiles.duration, axis=1) + way.profile.duration
    np.testing.assert_allclose(found["duration"][0], duration, rtol=1e-10)
    same = np.max(np.abs(found["turns"][0] - way.turns), axis=(1, 2)) < 1e-9
    assert np.mean(same) > 0.99
    np.testing.assert_allclose(found["last"][0][same], way.last[same], atol=1e-9)
    assert set(np.unique(way.blocked)) >= {0.0, 2.0}
