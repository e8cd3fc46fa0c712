"""The dispersed cases of the recoveries: what they are, and how they are counted."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.failures import holdable
from gyrostat.papers.blocks import in_blocks
from gyrostat.papers.carvalho_fenili.requirements import counted
from gyrostat.papers.carvalho_fenili.with_momentum import KINDS, full_beside_reduced
from gyrostat.papers.carvalho_fenili.with_momentum import draw as draw_with_momentum
from gyrostat.papers.carvalho_fenili.without_momentum import REQUIREMENTS, draw


def scalar_last(quaternion):
    return Rotation.from_quat(np.asarray(quaternion), scalar_first=True)


@pytest.mark.parametrize("kind", KINDS)
def test_targets_with_momentum_can_be_held_in_the_time_that_the_issue_allows(kind):
    random = np.random.default_rng(3)
    for _ in range(5):
        case = draw_with_momentum(random, kind, "tilted", 0.05)
        working, total = np.asarray(case.plant.working), np.asarray(case.plant.total_momentum)
        (failed,) = np.flatnonzero(~working)
        kept = float(case.start.rotor_momentum[failed])
        answer = holdable(
            case.plant.spacecraft, total, failed={int(failed): kept}, target=case.target
        )
        assert answer.holdable
        rho = np.sqrt(total @ total - kept**2)
        assert 0.1 <= rho <= 2.9 * np.sqrt(3.0)
        assert case.allowed == pytest.approx(100.0 + 15.0 * 16.0 / rho)
        own = np.linalg.eigvalsh(case.plant.spacecraft.inertia)
        np.testing.assert_allclose(own, [8.0, 12.0, 16.0])
        known = np.linalg.eigvalsh(case.controller.law.wheels.inertia)
        np.testing.assert_allclose(np.abs(known / own - 1.0), 0.05)
        rate = np.linalg.norm(case.plant.rate(case.start))
        assert (rate < 1e-12) == (kind == "frozen")


def test_targets_without_momentum_are_the_nearest_that_can_be_held():
    random = np.random.default_rng(5)
    for goal in REQUIREMENTS:
        case = draw(random, goal, tilted=True)
        total = np.array(case.start.momentum)
        assert goal.least - 1e-12 <= np.linalg.norm(total) <= goal.most + 1e-12
        (failed,) = np.flatnonzero(np.asarray(case.plant.failures.seized))
        assert abs(scalar_last(case.target).inv().apply(total)[failed]) < 1e-12
        # of all rates that are left to the body once the wheels took what they can, the least
        rate = np.array(case.plant.rate(case.start))
        normal = np.asarray(case.plant.spacecraft.inertia_locked())[failed]
        across = np.linalg.norm(np.cross(rate, normal)) / np.linalg.norm(normal)
        assert (across < 1e-12) != goal.tumbling


def test_cases_are_counted():
    late = np.array([1.0, 104.9, 105.1, np.inf])
    values, counts = counted("goals.zero", late, 105.0, "worst_s")
    assert values == {"goals.zero_share": 0.5, "goals.zero_worst_s": None}
    assert counts == {"zero": "2 of 4 settle in time, 3 at all."}
    values, _ = counted("goals.momentum_cube_5pct", np.array([0.3, 1.0]), 1.0, "worst_ratio")
    assert list(values.values()) == [1.0, 1.0]


@pytest.mark.parametrize("threads", [1, 2])
def test_blocks_are_filled_up_and_cut_again(threads):
    sizes, told = [], []

    def block(cases):
        sizes.append(len(cases))
        return np.array(cases, dtype=float)

    blocks = in_blocks(
        list(range(120)), 50, block, say=told.append, name="counting", threads=threads
    )
    np.testing.assert_array_equal(np.concatenate(list(blocks)), np.arange(120))
    assert sizes == [50, 50, 50]
    assert told[-1] == "counting: 120 of 120"


@pytest.mark.slow
def test_both_models_settle_together():
    apart, change = full_beside_reduced(4)
    assert apart <= 0.5
    assert change < 1e-8
