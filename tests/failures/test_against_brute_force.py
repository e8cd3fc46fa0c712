"""Emptiness, the nearest attitude and controllability, by sampling and by rank."""

from pathlib import Path

import numpy as np
import pytest

from gyrostat.core import rotations
from gyrostat.failures import controllability_matrix, holdable

CASES = 320


@pytest.fixture(scope="module")
def brute(module_at):
    return module_at(Path(__file__).with_name("brute.py"))


def angle(first, second):
    return np.arctan2(
        np.linalg.norm(np.cross(first, second), axis=-1), np.sum(first * second, axis=-1)
    )


def test_emptiness_and_nearest_attitude(brute):
    seen = {}
    for seed in range(CASES):
        drawn = brute.Drawn(seed)
        answer = holdable(drawn.body, drawn.momentum, failed=drawn.failed, target=drawn.target)
        assert answer.rank == drawn.rank
        wanted = rotations_to_body(drawn.target, drawn.momentum)
        samples = drawn.samples()
        radius = np.linalg.norm(drawn.momentum)
        if drawn.rank == 0:
            samples = samples[np.abs(np.linalg.norm(samples, axis=1) - radius) < 1e-9 * radius]
        sampled = samples[drawn.holds(samples)]
        kind = (drawn.rank, answer.empty)
        seen[kind] = seen.get(kind, 0) + 1
        if answer.empty:
            assert not len(sampled), seed
            continue
        there = answer.momentum_in_body
        assert drawn.holds(there[None])[0], seed
        assert np.linalg.norm(there) == pytest.approx(radius, rel=1e-8)
        assert angle(there, wanted) == pytest.approx(answer.angle, abs=1e-9)
        # it can be held, and no sample that can be held is nearer
        if len(sampled):
            assert np.min(angle(sampled, wanted)) >= answer.angle - 1e-7, seed
        held = answer.wheel_momentum[: len(drawn.axes)]
        np.testing.assert_allclose(held @ drawn.axes + drawn.frozen, there, atol=1e-9)
        share = np.max(np.abs(held) / drawn.limits, initial=0.0)
        assert answer.margin == pytest.approx(1.0 - share, abs=1e-7)
    # every kind was met, so that none of the above was empty talk
    assert all(seen.get((rank, kind), 0) >= 3 for rank in range(4) for kind in (True, False))


def rotations_to_body(attitude, vector):
    q0, q = attitude[0], -attitude[1:]
    return vector + 2.0 * np.cross(q, np.cross(q, vector) + q0 * vector)


def test_the_attitude_has_the_momentum_and_the_angle_that_are_told(brute):
    for seed in range(0, CASES, 20):
        drawn = brute.Drawn(seed)
        answer = holdable(drawn.body, drawn.momentum, failed=drawn.failed, target=drawn.target)
        if answer.empty:
            continue
        in_body = rotations.to_body(answer.attitude, drawn.momentum)
        np.testing.assert_allclose(in_body, answer.momentum_in_body, atol=1e-9)
        turned = rotations.error_angle(answer.attitude, drawn.target)
        assert float(turned) == pytest.approx(answer.angle, abs=1e-7)


def test_controllability_is_the_rank_of_the_controllability_matrix(brute):
    met = {}
    for seed in range(CASES):
        drawn = brute.Drawn(seed)
        momentum, axes, inertia = drawn.momentum, drawn.axes, drawn.inertia
        special = seed % 5
        # points that no random draw meets: momentum across or along what decides
        if drawn.rank == 2 and special == 0:
            momentum = np.cross(axes[0], axes[1]) * drawn.random.uniform(0.5, 2.0)
        if drawn.rank == 1 and special == 0:
            momentum = np.cross(axes[0], drawn.random.normal(size=3))
        if drawn.rank == 1 and special == 1:
            momentum = np.linalg.solve(inertia, axes[0]) * 20.0
        if special == 2:
            momentum = np.zeros(3)
        # the failed wheels hold what puts this momentum at rest with the working ones empty
        lost = momentum / (np.linalg.norm(momentum) or 1.0)
        lost = lost if np.any(lost) else np.array([1.0, 0.0, 0.0])
        body = brute.spacecraft(np.vstack([axes.reshape(-1, 3), lost]), np.inf, inertia)
        failed = {len(axes): float(np.linalg.norm(momentum))}
        answer = holdable(body, momentum, failed=failed, target=[1.0, 0.0, 0.0, 0.0])
        assert answer.holdable
        np.testing.assert_allclose(answer.momentum_in_body, momentum, atol=1e-7)
        full = 3 + len(axes)
        assert answer.controllable == (brute.rank_of_motion(inertia, axes, momentum) == full), seed
        if len(axes):
            scaled = controllability_matrix(inertia, axes.T, momentum)
            blocks = np.split(scaled, 4, axis=1)
            sizes = [np.linalg.norm(block) for block in blocks]
            scaled = np.hstack([b / s for b, s in zip(blocks, sizes, strict=True) if s > 1e-12])
            values = np.linalg.svd(scaled, compute_uv=False)
            assert answer.controllable == (int(np.sum(values > 1e-7)) == full), seed
        kind = (drawn.rank, special if special < 3 else 3, answer.controllable)
        met[kind] = met.get(kind, 0) + 1
    assert {(2, 0, False), (2, 3, True), (1, 0, False), (1, 1, False), (1, 3, True)} <= set(met)
    assert {(3, 2, True), (2, 2, False), (0, 3, False)} <= set(met)
