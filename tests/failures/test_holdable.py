"""What is derived about failed wheels: formulas, certificates, invariances, what is refused."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from gyrostat.core.errors import InputError
from gyrostat.failures import holdable, holdable_sky

IDENTITY = [1.0, 0.0, 0.0, 0.0]
X, Y, Z = np.eye(3)
SEEDS = st.integers(0, 2**31)


@pytest.fixture(scope="module")
def brute(module_at):
    return module_at(Path(__file__).with_name("brute.py"))


@pytest.fixture(scope="module")
def cube(brute):
    return brute.spacecraft(np.eye(3), 3.0, 12.0 * np.eye(3))


def quaternion(rotation):
    return rotation.as_quat(scalar_first=True)


def test_rank_two_without_limits_in_closed_form(brute):
    random = np.random.default_rng(5)
    for _ in range(40):
        axes = brute.unit(random, 3)
        body = brute.spacecraft(axes, np.inf)
        inertia = np.asarray(body.inertia)
        normal = np.cross(axes[0], axes[1]) / np.linalg.norm(np.cross(axes[0], axes[1]))
        frozen = random.uniform(-2.0, 2.0)
        level = frozen * (normal @ axes[2])
        momentum = brute.unit(random) * random.uniform(0.2, 2.0)
        radius = np.linalg.norm(momentum)
        target = Rotation.random(random_state=random)
        answer = holdable(body, momentum, failed={2: frozen}, target=quaternion(target))
        wanted = target.inv().apply(momentum)
        across = np.linalg.norm(inertia @ normal)
        excess = abs(normal @ wanted - level)
        assert answer.at_target.excess == pytest.approx(excess, rel=1e-9)
        assert answer.at_target.rate == pytest.approx(excess / across, rel=1e-9)
        if abs(level) > radius:
            assert answer.empty
            bound = (abs(level) - radius) / across
            assert answer.for_ever.rate == pytest.approx(bound, rel=1e-9)
            continue
        circle = np.arccos(level / radius)
        to_normal = np.arccos(normal @ wanted / radius)
        assert answer.angle == pytest.approx(abs(circle - to_normal), abs=1e-7)
        assert (answer.dimension, answer.margin, answer.controllable) == (2, 1.0, True)
        boresight = brute.unit(random)
        sky = holdable_sky(body, momentum, failed={2: frozen}, boresight=boresight)
        tilt = np.arccos(normal @ boresight)
        assert sky.fraction == pytest.approx(np.sin(circle) * np.sin(tilt), abs=1e-9)


def test_rates_within_the_limits_are_never_below_the_certificates(brute):
    checked = 0
    for seed in range(60):
        drawn = brute.Drawn(seed)
        answer = holdable(drawn.body, drawn.momentum, failed=drawn.failed, target=drawn.target)
        random, inverse = np.random.default_rng(seed), np.linalg.inv(drawn.inertia)
        reach = np.minimum(drawn.limits, 10.0)
        held = random.uniform(-1.0, 1.0, (2000, len(reach))) * reach
        corners = random.random(held.shape) < 0.5
        held = np.where(corners, np.sign(held) * reach, held) @ drawn.axes + drawn.frozen
        wanted = Rotation.from_quat(drawn.target, scalar_first=True).inv().apply(drawn.momentum)
        rate = np.linalg.norm((wanted - held) @ inverse, axis=1)
        assert np.min(rate) >= answer.at_target.rate - 1e-12
        if answer.empty:
            anywhere = brute.unit(random, 2000) * np.linalg.norm(drawn.momentum)
            rate = np.linalg.norm((anywhere - held) @ inverse, axis=1)
            assert np.min(rate) >= answer.for_ever.rate - 1e-12
            assert answer.for_ever.rate > 0.0
            assert answer.for_ever.rate <= answer.at_target.rate * (1.0 + 1e-9)
            checked += 1
        else:
            assert answer.for_ever.rate == 0.0
    assert checked > 10


def test_boresights_against_brute_force(brute):
    met = set()
    for seed in range(80):
        drawn = brute.Drawn(seed)
        random, total = np.random.default_rng(seed), drawn.momentum
        boresight, wanted = brute.unit(random, 2)
        failed = {"failed": drawn.failed}
        answer = holdable(drawn.body, total, boresight=(boresight, wanted), **failed)
        sky, radius = answer.sky, np.linalg.norm(total)
        assert answer.holdable == bool(sky.holdable(wanted))
        samples = drawn.samples(4000)
        if drawn.rank == 0:
            samples = samples[np.abs(np.linalg.norm(samples, axis=1) - radius) < 1e-9]
        polar = np.arccos(samples[drawn.holds(samples)] @ boresight / radius)
        met.add((drawn.rank, answer.empty, answer.holdable))
        if answer.empty:
            assert not len(polar)
            assert sky.fraction == 0.0
            continue
        # each sample points the boresight somewhere on the map, and none nearer to what is wanted
        axis = total / radius
        aside = np.cross(axis, wanted) / np.linalg.norm(np.cross(axis, wanted))
        assert np.all(sky.holdable(np.outer(np.cos(polar), axis) + np.outer(np.sin(polar), aside)))
        away = np.abs(polar - np.arccos(axis @ wanted))
        assert np.min(away, initial=np.inf) >= answer.angle - 1e-7
        # the attitude does what it says
        attitude = Rotation.from_quat(answer.attitude, scalar_first=True)
        np.testing.assert_allclose(attitude.apply(boresight), answer.direction, atol=1e-9)
        np.testing.assert_allclose(attitude.inv().apply(total), answer.momentum_in_body, atol=1e-9)
        assert drawn.holds(answer.momentum_in_body[None])[0]
        assert np.arccos(np.clip(answer.direction @ wanted, -1.0, 1.0)) == pytest.approx(
            answer.angle, abs=1e-7
        )
        assert (answer.at_target.rate == 0.0) == answer.holdable
        if answer.holdable and drawn.rank == 3:
            rolled = Rotation.from_rotvec(random.uniform(-3.0, 3.0) * wanted) * attitude
            other = holdable(drawn.body, total, target=quaternion(rolled), **failed)
            assert not other.holdable or other.margin <= answer.margin + 0.02
    assert {(2, False, True), (2, False, False), (3, False, True), (3, False, False)} <= met


def test_the_grid_covers_the_fraction_of_the_sphere(cube):
    total = [0.58895, 0.04587, 0.81442]
    sky = holdable_sky(cube, total, failed={0: 0.3}, boresight=[1.0, 0.5, 0.2])
    longitude, latitude, cells = sky.grid(240)
    assert cells.shape == (240, 480) == (len(latitude), len(longitude))
    share = np.sum(cells * np.cos(latitude)[:, None]) / np.sum(np.cos(latitude)) / len(longitude)
    assert share == pytest.approx(sky.fraction, abs=2e-3)
    assert 0.1 < sky.fraction < 0.9


def test_how_long_a_target_is_kept(cube):
    """A steady turn across the tolerance is possible, and little more."""
    wide = {"failed": {0: 0.3}, "target": IDENTITY}
    momentum = np.array([0.58895, 0.04587, 0.81442])
    rate = holdable(cube, momentum, **wide).at_target.rate
    assert rate == pytest.approx(0.28895 / 12.0, rel=1e-12)
    for tolerance, slack in ((1e-6, 1e-4), (1e-4, 1e-2), (1e-2, 0.5)):
        dwell = holdable(cube, momentum, tolerance=tolerance, **wide).dwell
        steady = 2.0 * tolerance / rate
        assert steady <= dwell * (1.0 + 2.0 * tolerance) <= steady * (1.0 + slack)
    # within the tolerance something can be held, or nothing bounds the rate: there is no bound
    assert holdable(cube, momentum, tolerance=0.4, **wide).dwell is None
    free = dataclasses.replace(cube.wheels, momentum_limit=np.inf)
    free = dataclasses.replace(cube, wheels=free)
    assert holdable(free, momentum, tolerance=1e-4, **wide).dwell is None


def test_the_dwell_time_solves_the_inequalities_it_comes_from(brute):
    """Both bounds found by bisection of what the docstring of `longest_dwell` derives."""
    random, met = np.random.default_rng(9), set()
    for _ in range(200):
        inertia = np.diag(random.uniform(8.0, 15.0, 3))
        body = brute.spacecraft(np.eye(3), 3.0, inertia)
        momentum, frozen = brute.unit(random) * random.uniform(0.5, 4.0), random.uniform(-2.0, 2.0)
        e = 10.0 ** random.uniform(-4.0, -0.3)
        answer = holdable(body, momentum, failed={0: frozen}, target=IDENTITY, tolerance=e)
        radius = np.linalg.norm(momentum)
        if abs(abs(answer.at_target.direction[0]) - 1.0) > 1e-9:
            continue  # a limit of a working wheel binds as well
        side = answer.at_target.direction[0]
        away = np.arccos(side * momentum[0] / radius)
        left = radius * np.cos(min(away + e, np.pi)) - side * frozen
        if left <= 0.0:
            assert answer.dwell is None
            continue
        least, steady = np.diag(inertia).min(), left / inertia[0, 0]
        fastest = (radius + np.hypot(np.hypot(3.0, 3.0), frozen)) / least

        def stays(time, rate, e=e, steady=steady):
            gained = time * (steady * np.cos(e / 2) - rate * np.sin(e / 2))
            return gained <= 4.0 * np.sin(e / 2)

        def coning(time, e=e, fastest=fastest, radius=radius, least=least):
            """Root mean square rate while the attitude stays."""
            torque = 0.1 * np.sqrt(2.0)
            push = np.tan(e) * (2.0 * fastest / time + torque / least)
            roots = np.roots([1.0, -np.tan(e) * radius / least, -push])
            return np.max(roots.real)

        def can(time, fastest=fastest, stays=stays, coning=coning):
            return stays(time, fastest) and stays(time, coning(time))

        if answer.dwell is None:
            assert can(1e9)
        else:
            assert can(answer.dwell * (1.0 - 1e-6))
            assert not can(answer.dwell * (1.0 + 1e-6))
            met.add(bool(stays(answer.dwell * 1.01, fastest)))
    assert met == {True, False}


def test_coning_can_keep_a_target_that_is_nearly_holdable(cube):
    """To leading order for ever below an excess of e^1.5 sqrt(J u)/2, u the torque of two wheels.

    The target lies just outside the tolerance of what can be held: there the excess is about
    e rho, far above it, unless rho is small. So the momentum is nearly along x.
    """
    tolerance, torque = 2e-3, 0.1 * np.sqrt(2.0)
    threshold = 0.5 * tolerance**1.5 * np.sqrt(12.0 * torque)
    momentum = np.array([1e-4, 0.0, 0.0])
    for share, bounded in ((0.98, False), (1.02, True)):
        # no momentum to speak of: everything that is left is frozen along x, and nothing is held
        frozen = {0: momentum[0] + share * threshold}
        answer = holdable(cube, momentum, failed=frozen, target=IDENTITY, tolerance=tolerance)
        assert answer.empty
        assert (answer.dwell is not None) == bounded


def test_no_law_keeps_a_target_longer_than_told(cube):
    """Steered home as hard as the wheels can, or coned, from wherever: it leaves in time."""
    momentum, frozen, tolerance = np.array([0.58895, 0.04587, 0.81442]), 0.5, 0.02
    answer = holdable(cube, momentum, failed={0: frozen}, target=IDENTITY, tolerance=tolerance)
    random, runs, step = np.random.default_rng(3), 100, 5e-3
    starts = random.normal(size=(runs, 3))
    starts *= tolerance * random.random((runs, 1)) ** 0.3 / np.linalg.norm(starts, axis=1)[:, None]
    attitude = Rotation.from_rotvec(starts)
    held = random.uniform(-1.0, 1.0, (runs, 2)) * 0.3 + momentum[1:]
    kept = np.zeros(runs)
    inside = np.ones(runs, dtype=bool)
    spin = random.uniform(0.0, 30.0, runs)
    for k in range(int(1.2 * answer.dwell / step)):
        rate = (attitude.inv().apply(momentum) - np.insert(held, 0, frozen, axis=1)) / 12.0
        turn = attitude.as_rotvec()
        # half of them steer home, half turn in circles
        push = np.where(
            (np.arange(runs) % 2 == 0)[:, None],
            turn[:, 1:] * 40.0 + rate[:, 1:] * 12.0,
            np.stack([np.cos(spin * k * step), np.sin(spin * k * step)], axis=1),
        )
        held = np.clip(held + step * np.clip(push, -0.1, 0.1), -3.0, 3.0)
        attitude = attitude * Rotation.from_rotvec(step * rate)
        inside &= np.linalg.norm(turn, axis=1) <= tolerance
        kept += inside * step
    assert np.max(kept) <= answer.dwell
    assert np.max(kept) > 0.5 * answer.dwell


@settings(max_examples=25)
@given(SEEDS)
def test_inertial_space_has_no_directions_of_its_own(brute, seed):
    drawn = brute.Drawn(seed)
    turn = Rotation.random(random_state=seed)
    target = Rotation.from_quat(drawn.target, scalar_first=True)
    known = {"failed": drawn.failed}
    one = holdable(drawn.body, drawn.momentum, target=drawn.target, **known)
    turned = turn.apply(drawn.momentum)
    other = holdable(drawn.body, turned, target=quaternion(turn * target), **known)
    agree(one, other)
    sky = {"boresight": [0.3, 0.5, -0.8], **known}
    assert holdable_sky(drawn.body, drawn.momentum, **sky).fraction == pytest.approx(
        holdable_sky(drawn.body, turned, **sky).fraction, abs=1e-9
    )


@settings(max_examples=25)
@given(SEEDS)
@example(463)  # two wheels on one axis: rounding chose their momenta
def test_the_body_has_no_axes_of_its_own(brute, seed):
    drawn = brute.Drawn(seed)
    turn = Rotation.random(random_state=seed)
    matrix = turn.as_matrix()
    target = Rotation.from_quat(drawn.target, scalar_first=True)
    body = drawn.body
    turned = dataclasses.replace(
        body,
        inertia=matrix @ body.inertia @ matrix.T,
        wheels=dataclasses.replace(body.wheels, axes=matrix @ body.wheels.axes),
    )
    known = {"failed": drawn.failed}
    one = holdable(body, drawn.momentum, target=drawn.target, **known)
    other = holdable(turned, drawn.momentum, target=quaternion(target * turn.inv()), **known)
    agree(one, other)
    if not one.empty:
        np.testing.assert_allclose(one.wheel_momentum, other.wheel_momentum, atol=1e-6)


def agree(one, other):
    for name in ("holdable", "empty", "rank", "dimension", "controllable"):
        assert getattr(one, name) == getattr(other, name)
    assert one.at_target.rate == pytest.approx(other.at_target.rate, abs=1e-9)
    assert one.for_ever.rate == pytest.approx(other.for_ever.rate, rel=1e-6)
    if not one.empty:
        assert one.angle == pytest.approx(other.angle, abs=1e-7)
        assert one.margin == pytest.approx(other.margin, abs=1e-7)


@pytest.mark.parametrize(
    ("failed", "momentum", "expected"),
    [
        # nothing failed; three axes carry any direction up to their limits
        ({}, [1.0, 1.0, 1.0], {"holdable": True, "rank": 3, "dimension": 3, "controllable": True}),
        ({}, [4.0, 0.0, 0.0], {"holdable": False, "rank": 3, "dimension": 3, "margin": 0.0}),
        ({}, [3.1, 3.1, 3.1], {"empty": True, "rank": 3}),
        # zero momentum: all attitudes or none
        ({0: 0.0}, [0.0, 0.0, 0.0], {"holdable": True, "dimension": 3, "controllable": False}),
        ({0: 0.1}, [0.0, 0.0, 0.0], {"empty": True, "angle": None}),
        ({0: 0.0, 1: 0.0}, [0.0, 0.0, 0.0], {"holdable": True, "dimension": 3, "rank": 1}),
        # one wheel: two points, or none
        ({0: 0.0, 1: 0.0}, [0.0, 0.0, 2.0], {"holdable": True, "dimension": 1}),
        ({0: 0.0, 1: 0.0}, [0.0, 0.0, -2.0], {"holdable": True, "dimension": 1}),
        ({0: 0.5, 1: 0.0}, [0.0, 0.0, 2.0], {"holdable": False, "controllable": True}),
        ({0: 2.5, 1: 0.0}, [0.0, 0.0, 2.0], {"empty": True, "rank": 1}),
        ({0: 0.0, 1: 0.0}, [0.0, 0.0, 3.5], {"empty": True, "rank": 1}),
        # none: the frozen momentum is all there is, or it is not
        ({0: 0.0, 1: 0.0, 2: 1.0}, [0.0, 0.0, 1.0], {"holdable": True, "dimension": 1, "rank": 0}),
        ({0: 0.0, 1: 0.0, 2: 1.0}, [0.0, 1.0, 0.0], {"angle": np.pi / 2, "controllable": False}),
        ({0: 0.0, 1: 0.0, 2: 0.0}, [0.0, 0.0, 1.0], {"empty": True, "rank": 0}),
        ({0: 0.0, 1: 0.0, 2: 0.0}, [0.0, 0.0, 0.0], {"holdable": True, "rank": 0}),
        # the plane touches the sphere: one momentum in body axes, and no say about its direction
        ({0: 1.0}, [1.0, 0.0, 0.0], {"holdable": True, "dimension": 1, "controllable": False}),
        # the target is opposite to all that is held: any half turn is as good as another
        ({0: 1.0}, [-1.0, 0.0, 0.0], {"angle": np.pi, "dimension": 1}),
    ],
)
def test_what_a_cube_holds(cube, failed, momentum, expected):
    answer = holdable(cube, momentum, failed=failed, target=IDENTITY, tolerance=1e-3)
    for name, value in expected.items():
        found = getattr(answer, name)
        assert found == (pytest.approx(value) if isinstance(value, float) else value), name
    assert (answer.reason is not None) == answer.empty
    assert (answer.for_ever.rate > 0.0) == answer.empty
    json.dumps(answer.to_dict(), allow_nan=False)


def test_wheels_on_one_axis_and_in_one_plane(brute):
    pair = brute.spacecraft([Z, Z, -Z], [1.0, 2.0, 0.5], 12.0 * np.eye(3))
    answer = holdable(pair, [0.0, 0.0, 3.0], failed={}, target=IDENTITY)
    assert (answer.rank, answer.holdable) == (1, True)
    np.testing.assert_allclose(answer.wheel_momentum, np.array([1.0, 2.0, -0.5]) * 6.0 / 7.0)
    assert holdable(pair, [0.0, 0.0, 3.6], failed={}, target=IDENTITY).empty
    # three wheels of one plane to seven digits, as a drawing gives them
    tilted = np.array([X, Y, [np.sqrt(0.5), np.sqrt(0.5), 1e-8]])
    flat = brute.spacecraft(tilted, np.inf, 12.0 * np.eye(3))
    assert holdable(flat, [0.0, 0.6, 0.8], failed={}, target=IDENTITY).rank == 2


def test_the_bound_for_ever_without_momentum(brute):
    """A frozen wheel that two others with limits cannot make up for."""
    body = brute.spacecraft([X, Y, (X + Y) / np.sqrt(2.0)], [0.2, 0.2, 3.0], 12.0 * np.eye(3))
    answer = holdable(body, np.zeros(3), failed={2: 1.0}, target=IDENTITY)
    left = np.sqrt(2.0) * (np.sqrt(0.5) - 0.2)
    assert answer.empty
    assert answer.for_ever.rate == pytest.approx(left / 12.0, rel=1e-9)


def test_four_wheels_less_one_hold_everything_within_their_limits(brute):
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3.0)
    body = brute.spacecraft(corners, 3.0)
    for lost in range(4):
        answer = holdable(body, [0.5, -0.4, 0.3], failed={lost: 0.7}, target=IDENTITY)
        assert (answer.holdable, answer.rank, answer.controllable) == (True, 3, True)
        np.testing.assert_allclose(answer.wheel_momentum @ corners, [0.5, -0.4, 0.3], atol=1e-12)
        assert answer.wheel_momentum[lost] == 0.7


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"momentum": [1.0, 2.0]}, r"momentum: found \[1.0, 2.0\]"),
        ({"momentum": [1.0, np.nan, 0.0]}, "momentum"),
        ({"momentum": "fast"}, "found fast"),
        ({"failed": {3: 0.0}}, "found wheel 3, expected 0 to 2"),
        ({"failed": {"x": 0.0}}, "found wheel x"),
        ({"failed": {0: np.inf}}, "failed wheel 0: found inf"),
        ({"target": None}, "target and boresight: found none"),
        ({"boresight": (X, Y)}, "target and boresight: found both"),
        ({"target": [1.0, 1.0, 0.0, 0.0]}, "length 1.41421"),
        ({"target": None, "boresight": (X, [0.0, 0.0, 0.0])}, "direction to point at: found zero"),
        ({"tolerance": 2.0}, "tolerance: found 2"),
        ({"target": None, "boresight": (X, Y), "tolerance": 0.1}, "tolerance: found one for a"),
    ],
)
def test_what_is_no_question(cube, change, found):
    known = {"momentum": [0.1, 0.2, 0.3], "failed": {0: 0.0}, "target": IDENTITY}
    with pytest.raises(InputError, match=found):
        holdable(cube, **{**known, **change})


def test_what_is_no_single_spacecraft(cube):
    with pytest.raises(InputError, match="principal inertia -1"):
        holdable(dataclasses.replace(cube, inertia=-np.eye(3)), X, failed={}, target=IDENTITY)
    several = dataclasses.replace(cube, inertia=np.stack([cube.inertia] * 2))
    with pytest.raises(InputError, match="found several"):
        holdable(several, X, failed={}, target=IDENTITY)
