"""Ways around cones from random starts: rotations, angles and bodies apart from gyrostat."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turned

from gyrostat.codegen.flight import Entry, emit
from gyrostat.control.guidance import SlewLimits
from gyrostat.control.guidance.bodies import NO_BODY, Bodies, Sky
from gyrostat.control.guidance.way_around import PARTS, Start, way_around
from gyrostat.core.jax64 import jax, jnp

pytestmark = pytest.mark.optimised
LIMITS = SlewLimits(rate=0.01, acceleration=5e-4)
CASES = 400
BORESIGHTS = np.array([[0.0, 0.0, 1.0], [0.0, 2.0, -1.0]]) / [[1.0], [np.sqrt(5.0)]]
SPIN = 1e-3
"""Rate at which the bodies turn about z in axes of the target, rad/s."""


def moved(directions, time):
    """Directions at a time; they turn about z."""
    angle = SPIN * time
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    turn = jnp.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return directions @ turn.T


def way_of(offset, directions, angles):
    """Way from an attitude relative to the target."""

    def at(time):
        return Sky(moved(directions, time), angles)

    def profile(turn, offset, time):
        return LIMITS.profile(turn, offset, time)

    return way_around(
        Start(offset, jnp.zeros(()), profile, 0.01), Bodies(jnp.asarray(BORESIGHTS), at)
    )


ways = jax.jit(jax.vmap(way_of))


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
    angle = SPIN * time
    turn = Turned.from_rotvec(angle[:, None] * np.array([0.0, 0.0, 1.0]))
    least = np.full(len(time), np.inf)
    for instrument, boresight in enumerate(BORESIGHTS):
        sight = rotated.apply(boresight)
        for body in range(directions.shape[1]):
            toward = turn.apply(directions[:, body])
            cosine = np.clip(np.sum(sight * toward, axis=1), -1.0, 1.0)
            beyond = np.arccos(cosine) - angles[instrument, body]
            counts = angles[instrument, body] > 0.0
            least = np.where(counts, np.minimum(least, beyond), least)
    return least


def random_cases(angles):
    """Starts, directions of the bodies, the ways, and angles beyond the cones along them."""
    rng = np.random.default_rng(4)
    offset = Turned.random(CASES, rng=rng)
    directions = rng.normal(size=(CASES, 2, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    starts = offset.as_quat(canonical=True, scalar_first=True)
    way = jax.tree.map(np.asarray, ways(starts, directions, np.tile(angles, (CASES, 1, 1))))
    rows = [*along(way, np.linspace(0.0, 1.0, 41))]
    assert np.max((rows[0][0].inv() * offset).magnitude()) < 1e-9
    assert np.max(rows[-1][0].magnitude()) < 1e-9
    beyond = np.array([apart(rotated, directions, angles, time) for rotated, time in rows])
    return way, beyond


@pytest.mark.parametrize(
    "degrees",
    [
        [[35.0, 0.0], [0.0, 0.0]],
        [[120.0, 0.0], [0.0, 0.0]],
        [[35.0, 15.0], [50.0, 0.0]],
    ],
)
def test_no_way_enters_a_cone_without_a_word(degrees):
    angles = np.where(np.array(degrees) > 0.0, np.radians(degrees), NO_BODY)
    way, beyond = random_cases(angles)
    outside, clear = beyond[0] > 0.0, beyond[-1] > 0.08
    assert np.min(beyond[:, way.blocked == 0.0]) > 0.0
    assert np.all(way.blocked[~outside] >= 2.0)
    free = outside & clear
    # a target that bodies turn past may be blocked in time; of one cone that rests, none is
    assert np.mean(way.blocked[free] == 0.0) > (0.95 if degrees[0][0] == 120.0 else 0.99)
    detours = free & (np.linalg.norm(way.turns[:, 1], axis=1) > 1e-6)
    assert np.count_nonzero(detours) >= 2


def test_a_turn_that_starts_inside_leaves_by_the_shortest_way_and_says_so():
    angles = np.array([[np.radians(35.0), NO_BODY], [NO_BODY, NO_BODY]])
    way, beyond = random_cases(angles)
    inside = (beyond[0] < 0.0) & (beyond[-1] > 0.08)
    assert np.count_nonzero(inside) > 20
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


def test_a_body_that_sways_within_a_part_is_not_passed_without_a_word():
    """The body is at its place at the ends of all parts, and 8 deg nearer between them."""
    turn = np.array([np.radians(120.0), 0.0, 0.0])
    part = float(LIMITS.profile(turn, np.eye(4)[0], 0.0).duration) / PARTS
    middle = Turned.from_rotvec(0.5 * turn).apply([0.0, 0.0, 1.0])
    across = np.array([1.0, 0.0, 0.0])
    offset = Turned.from_rotvec(turn).as_quat(scalar_first=True)

    @jax.jit
    def blocked(sway):
        def at(time):
            angle = np.radians(39.0) - sway * jnp.sin(jnp.pi * time / part) ** 2
            direction = jnp.cos(angle) * middle + jnp.sin(angle) * across
            return Sky(direction[None], jnp.full((1, 1), np.radians(35.0)))

        start = Start(offset, jnp.zeros(()), LIMITS.profile, 0.01)
        way = way_around(start, Bodies(jnp.array([[0.0, 0.0, 1.0]]), at))
        return way.blocked, way.turns

    for sway, says in ((0.0, 0.0), (np.radians(8.0), 1.0)):
        found, turns = blocked(sway)
        assert float(found) == says
        # about the eigenaxis, which is clear at the ends of all parts
        np.testing.assert_allclose(turns, 0.0, atol=1e-12)


def test_generated_c_finds_the_same_ways(tools, tmp_path):
    """Ties between waypoints are broken by rounding, which leaves the duration the same."""

    def flat(offset, directions, angles):
        way = way_of(offset, directions, angles)
        before = way.profiles.duration
        return way.blocked, before[0] + before[1] + way.profile.duration, way.turns, way.last

    angles = np.array([[np.radians(50.0), np.radians(20.0)], [np.radians(50.0), NO_BODY]])
    given = {"offset": np.zeros(4), "directions": np.zeros((2, 3)), "angles": angles}
    entry = Entry("way", flat, given, ("blocked", "duration", "turns", "last"))
    compiled = tools.Compiled(emit("around", [entry]), tmp_path)
    rng = np.random.default_rng(8)
    directions = rng.normal(size=(CASES, 2, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    starts = Turned.random(CASES, rng=rng).as_quat(canonical=True, scalar_first=True)
    every = {"offset": starts, "directions": directions, "angles": np.tile(angles, (CASES, 1, 1))}
    status, found = compiled("way", every)
    assert not status.any()
    way = jax.tree.map(np.asarray, ways(*every.values()))
    np.testing.assert_array_equal(found["blocked"][0], way.blocked)
    duration = np.sum(way.profiles.duration, axis=1) + way.profile.duration
    np.testing.assert_allclose(found["duration"][0], duration, rtol=1e-10)
    same = np.max(np.abs(found["turns"][0] - way.turns), axis=(1, 2)) < 1e-9
    assert np.mean(same) > 0.99
    np.testing.assert_allclose(found["last"][0][same], way.last[same], atol=1e-9)
    assert set(np.unique(way.blocked)) >= {0.0, 2.0}
