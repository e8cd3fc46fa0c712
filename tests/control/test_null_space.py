"""Null-space control: what the body feels of it, and where it brings the wheels."""

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
def _led(control, axes, works, momentum, room):
    """Where the momenta are after long, and the largest torque on the way."""

    def step(carry, _):
        momentum, most = carry
        torque = control(axes, works, momentum, room)
        return (momentum + 2.0 * torque, jnp.maximum(most, jnp.abs(torque))), None

    return jax.lax.scan(step, (momentum, jnp.zeros(axes.shape[1])), length=400)[0]


def led(momentum, *, control=CONTROL, axes=PYRAMID, works=ALL, room=ROOM):
    return tuple(map(np.asarray, _led(control, axes, works, jnp.asarray(momentum), room)))


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
