"""Null-space control: what the body feels of it, and where it brings the wheels."""

import dataclasses

import numpy as np
import pytest

from gyrostat.control import NullSpaceControl
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel import pyramid_axes

PYRAMID = pyramid_axes(4)
FREE = np.array([1.0, -1.0, 1.0, -1.0])
"""Torques in these proportions cancel."""
LIMIT = 2.0
CONTROL = NullSpaceControl.plan(PYRAMID, LIMIT, share=1.0)
ALL = np.ones(4, bool)
ROOM = np.full(4, np.inf)


@jax.jit
def _led(control, axes, works, momentum, room, wear):
    """Where the momenta are after long, and the largest torque on the way."""

    def step(carry, _):
        momentum, most = carry
        torque = control(axes, works, momentum, room, wear)
        return (momentum + 2.0 * torque, jnp.maximum(most, jnp.abs(torque))), None

    return jax.lax.scan(step, (momentum, jnp.zeros(axes.shape[1])), length=400)[0]


def led(momentum, *, control=CONTROL, axes=PYRAMID, works=ALL, room=ROOM, wear=1.0):
    wear = wear * np.ones(len(room))
    return tuple(map(np.asarray, _led(control, axes, works, jnp.asarray(momentum), room, wear)))


def clearance(momentum):
    """From zero and from the limit, the less of both over all wheels."""
    size = np.abs(momentum)
    return min(np.min(size), np.min(LIMIT - size))


@pytest.mark.parametrize("asked", [(0.0, 0, 0), (0.5, 0.3, -0.2), (0.1, -0.9, 0.8), (1.0, 1, 1)])
def test_wheels_go_where_the_worst_is_farthest_from_zero_and_from_its_limit(asked):
    """Against a search over the one free number of a pyramid; the body feels nothing."""
    start = np.linalg.pinv(PYRAMID) @ asked
    levels = np.linspace(-LIMIT, LIMIT, 4001)
    found = [clearance(start + z * FREE) for z in levels]
    near, _ = led(start + (levels[np.argmax(found)] + 0.05) * FREE)
    assert np.allclose(PYRAMID @ near, asked, atol=1e-12)
    assert clearance(near) == pytest.approx(max(found), abs=1e-3)
    # from elsewhere a gap that is not much narrower is kept
    assert clearance(led(start)[0]) > 0.5 * max(found) - 1e-3


def test_saturation_comes_before_zero_where_both_cannot_be_had():
    """Wheels that must be beyond the wanted momentum are so as little as can be."""
    asked = np.linalg.pinv(PYRAMID) @ [0.0, 6.5, 0.0]
    end, _ = led(asked + 0.3 * FREE)
    assert np.max(np.abs(end)) == pytest.approx(np.max(np.abs(asked)))
    assert np.max(np.abs(end)) > LIMIT


def test_the_sense_that_the_wheels_have_is_kept():
    for sense in (1.0, -1.0):
        end, _ = led(sense * 0.1 * FREE)
        assert np.allclose(end, sense * FREE, atol=1e-9)


def test_torques_keep_to_the_room_that_is_left():
    room = np.array([1e-3, 2e-3, 5e-3, 1e-4])
    end, most = led(np.zeros(4), room=room)
    assert np.all(most <= room * (1 + 1e-12))
    assert np.max(most) == pytest.approx(1e-4)
    assert np.allclose(led(np.zeros(4), room=np.zeros(4))[0], 0.0, atol=1e-20)
    assert np.all(np.abs(end) > 0.0)


def test_three_working_wheels_leave_no_freedom():
    """Whatever the failed one still has."""
    end, most = led([0.1, 0.2, 0.3, 0.7], works=np.array([True, True, True, False]))
    assert np.all(most == 0.0)
    assert np.array_equal(end, [0.1, 0.2, 0.3, 0.7])


def test_six_wheels_use_all_their_freedom_and_five_what_is_left():
    axes = pyramid_axes(6)
    control = NullSpaceControl.plan(axes, LIMIT)
    start = np.linalg.pinv(axes) @ [0.3, -0.2, 0.4] + np.array([0.4, 0, 0, -0.3, 0, 0])
    for works in (np.ones(6, bool), np.arange(6) != 2):
        end, _ = led(start, control=control, axes=axes, works=works, room=np.full(6, np.inf))
        assert np.allclose((axes * works) @ end, (axes * works) @ start, atol=1e-12)
        assert np.min(np.abs(end[works])) > 0.2
        assert np.max(np.abs(end[works])) < 0.9 * LIMIT


def test_what_cannot_be_planned_is_refused():
    with pytest.raises(InputError, match="leave no freedom"):
        NullSpaceControl.plan(np.eye(3), LIMIT)
    with pytest.raises(InputError, match="momentum limit"):
        NullSpaceControl.plan(PYRAMID, np.inf)
    with pytest.raises(InputError, match="gain"):
        NullSpaceControl(jnp.ones(4), jnp.ones(4), -1.0).check()
    with pytest.raises(InputError, match=r"found 0.3 to 0.2 N·m·s, expected a lower end"):
        NullSpaceControl.plan(PYRAMID, LIMIT, bands=[[0.3, 0.2]]).check()
    with pytest.raises(InputError, match=r"bands: found shape \(2, 4\), expected \(bands, 2"):
        NullSpaceControl(jnp.ones(4), jnp.ones(4), bands=jnp.ones((2, 4))).check()
    with pytest.raises(InputError, match="clearance"):
        NullSpaceControl.plan(PYRAMID, LIMIT, clearance=0.0).check()


BANDED = NullSpaceControl.plan(
    PYRAMID, LIMIT, share=1.0, bands=[[0.0, 0.1], [0.8, 0.95]], clearance=0.12
)
WEAR = np.array([1.0, 4.0, 1.0, 1.0])


def wanted_by_search(needed, wear, now, control=BANDED):
    """Where the wheels should be, by a search over a fine grid of the one free number."""
    clearance, bands = float(control.clearance), np.asarray(control.bands)[..., 0]
    grid = np.linspace(-3.0, 3.0, 60001)
    size = np.abs(needed + grid[:, None] * FREE)
    spoilt = np.zeros(size.shape, bool)
    for low, high in bands:
        spoilt |= (size > low) & (size < high)
    spoilt |= size < 1e-4
    allowed = np.all((size <= LIMIT) & ~spoilt, axis=1)
    changes = np.flatnonzero(np.diff(np.concatenate([[0], allowed, [0]])))
    gaps = [(grid[a], grid[b - 1]) for a, b in changes.reshape(-1, 2)]
    centres = -needed * FREE
    spans = [(c, c, w**2) for c, w in zip(centres, wear, strict=True)]
    for low, high in bands:
        spans += [(c + low, c + high, w) for c, _, w in spans[:4]]
        spans += [(c - high, c - low, w) for c, _, w in spans[:4]]
    slow = max(centres - LIMIT / wear), min(centres + LIMIT / wear)

    def part(gap):
        return [np.clip(end, *gap) for end in slow]

    def worth(gap):
        begin, end = part(gap)
        overlap, width = max(end - begin, 0.0), gap[1] - gap[0]
        if gap[0] <= now <= gap[1] and width > clearance and overlap > 0.0:
            return np.inf
        eps = 2e-4
        between = [
            cost
            for low, high, cost in spans
            if now < high <= gap[0] + eps or gap[1] - eps <= low < now
        ]
        return (overlap + 0.1 * width) / (1.0 + sum(between))

    best = max(gaps, key=worth)
    kept = min(clearance, 0.5 * (best[1] - best[0]))
    return np.clip(np.mean(part(best)), best[0] + kept, best[1] - kept)


@pytest.mark.parametrize("wear", [np.ones(4), WEAR])
def test_bands_and_wear_choose_the_gap_and_the_place_that_a_search_finds(wear):
    random = np.random.default_rng(4)
    for _ in range(12):
        needed = np.linalg.pinv(PYRAMID) @ random.uniform(-1.2, 1.2, 3)
        now = random.uniform(-1.0, 1.0)
        end, _ = led(needed + now * FREE, control=BANDED, wear=wear)
        found = FREE @ (end - needed) / 4.0
        assert found == pytest.approx(wanted_by_search(needed, wear, now), abs=1e-3)


def test_a_worn_wheel_turns_slowly_and_the_others_take_over():
    needed = np.linalg.pinv(PYRAMID) @ [0.4, 0.2, -0.3]
    fresh, worn = (led(needed + 0.6 * FREE, control=BANDED, wear=w)[0] for w in (1.0, WEAR))
    assert abs(worn[1]) <= LIMIT / 4.0 < abs(fresh[1])
    assert np.allclose(PYRAMID @ worn, PYRAMID @ fresh, atol=1e-12)


def test_the_body_feels_nothing_of_bands_and_wear():
    """Random momenta, wear and room: the torques cancel to rounding and keep to the room."""
    random = np.random.default_rng(5)
    for axes in (PYRAMID, pyramid_axes(6)):
        count = axes.shape[1]
        control = NullSpaceControl.plan(axes, LIMIT, bands=[[0.0, 0.3]], clearance=0.1)
        call = jax.jit(control.__call__)
        moved = 0.0
        for _ in range(20):
            momentum, room = random.uniform(-2, 2, count), random.uniform(0, 1e-2, count)
            wear = random.uniform(1, 5, count)
            torque = np.asarray(call(axes, np.ones(count, bool), momentum, room, wear))
            assert np.all(np.abs(axes @ torque) <= 1e-15 * 0.2 * np.max(np.abs(momentum)))
            assert np.all(np.abs(torque) <= room * (1 + 1e-12))
            moved += np.max(np.abs(torque))
        assert moved > 0.0


@pytest.mark.parametrize("room", [0.02, np.inf])
def test_the_time_in_a_band_is_what_the_room_or_the_crossing_gain_allows(room):
    """All wheels leave a narrow gap at 0.3 for the middle of that from 0.7 to 2, through a band."""
    bands = [[0.0, 0.3], [0.35, 0.7]]
    control = NullSpaceControl.plan(PYRAMID, LIMIT, share=1.0, bands=bands, clearance=0.6)
    step, period, z, times = jax.jit(control.__call__), 0.01, 0.33, 0
    while z < 1.0:
        torque = np.asarray(step(PYRAMID, ALL, z * FREE, np.full(4, room)))
        z += period * torque[0]
        times += 0.35 < z < 0.7
    quick = np.log((1.35 - 0.35) / (1.35 - 0.7)) / control.crossing_gain
    expected = 0.35 / room if np.isfinite(room) else quick
    assert times * period == pytest.approx(expected, abs=2 * period)


def test_without_gain_nothing_is_done():
    control = NullSpaceControl.plan(PYRAMID, LIMIT, bands=[[0.0, 0.3]])
    still = dataclasses.replace(control, gain=0.0)
    assert np.array_equal(led([0.1, 0.2, 0.3, 0.7], control=still)[0], [0.1, 0.2, 0.3, 0.7])


def test_bands_that_leave_no_gap_are_ignored():
    control = NullSpaceControl.plan(PYRAMID, LIMIT, bands=[[0.0, 3.0]])
    assert np.allclose(led(0.4 * FREE, control=control)[0], 0.4 * FREE, atol=1e-12)
