"""Carvalho and Fenili on wheels with limits: what is left after each failure, and how soon."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.papers.carvalho_fenili.laws import laws
from gyrostat.papers.carvalho_fenili.recoveries import (
    UNLIMITED,
    onset,
    recovered,
    recovery_claims,
)
from gyrostat.papers.carvalho_fenili.recovery_drawing import recovery_drawing

CASES = {"Mx": [0], "My": [1], "Mz": [2], "MxMy": [0, 1], "MxMz": [0, 2], "MyMz": [1, 2]}
FAILURES = ("frozen", "seized", "rundown")
H0 = np.array([0.58895, 0.04587, 0.81442])
# 3-1-3 angles phi 0, theta pi/2, psi 0
TARGET = Rotation.from_euler("x", 0.5 * np.pi)


@pytest.fixture(scope="module")
def runs():
    linear = recovered(laws().lqr)
    return {"lqr": linear, "sdre": linear}


@pytest.fixture(scope="module")
def claims(runs):
    return {claim.id: claim for claim in recovery_claims(runs)}


def nearest(momentum, failed, kept):
    """Angle from the target to the nearest rest, deg; None where there is none. Limits apart.

    With two wheels b lies on a circle about the failed axis, with one on two points; and the turn
    nearest to the target is the one from b at the target to the nearest such b.
    """
    size, wanted = np.linalg.norm(momentum), TARGET.inv().apply(momentum)
    across = size**2 - kept @ kept
    if across < 0.0:
        return None
    free = wanted.copy()
    free[failed] = 0.0
    there = kept + free * np.sqrt(across) / np.linalg.norm(free)
    return np.degrees(np.arccos(np.clip(wanted @ there / size**2, -1.0, 1.0)))


def test_the_total_momentum_is_that_of_table_2(claims):
    found = [claims[f"recover.momentum_{axis}"].ours for axis in "xyz"]
    np.testing.assert_allclose(found, H0, atol=5e-6)


def test_what_can_be_held_follows_from_the_momentum_at_the_failure(runs, claims):
    state = runs["lqr"].onset.state
    turn = Rotation.from_quat(np.roll(state.attitude, -1))
    # H = R (I w + J s): the body rate, and with it what a rotor holds in inertial space
    relative = 0.01 * np.asarray(state.wheel_speed)
    rate = (turn.inv().apply(H0) - relative) / 12.0
    assert np.max(np.abs(relative)) < 3.0
    for case, failed in CASES.items():
        for failure in FAILURES:
            prefix = f"recover.lqr.{case}.{failure}"
            kept = np.zeros(3)
            if failure == "frozen":
                kept[failed] = (relative + 0.01 * rate)[failed]
            expected = nearest(H0, failed, kept)
            angle, least = (
                claims[f"{prefix}.{name}"].ours for name in ("nearest_deg", "min_rate_rad_s")
            )
            if expected is None:
                assert angle is None
                # J is 11.99 without the rotors, and what is left over must turn with the body
                over = np.linalg.norm(kept) - np.linalg.norm(H0)
                assert least == pytest.approx(over / 11.99, rel=1e-3)
            else:
                assert angle == pytest.approx(expected, abs=2e-3)
                assert least == 0.0


def test_every_recovery_settles_or_says_why(runs, claims):
    assert sum(name.count(".") == 4 for name in claims) == 108
    for case, failed in CASES.items():
        for failure in FAILURES:
            row = claims[f"recover.lqr.{case}.{failure}.settle_s"]
            recovery = runs["lqr"].flown[case][failure]
            assert row.paper is None
            if recovery.plan.answer.angle is None:
                assert row.ours is None
                assert "can be held" in row.why
            elif len(failed) == 1:
                assert 0.0 < row.ours < 600.0
                late = recovery.flight.time.values >= row.ours
                assert np.all(recovery.flight.error.values[late] < np.radians(0.05))
                assert np.all(np.abs(recovery.flight.rate.values[late]) < 1e-4)
                assert not np.all(recovery.flight.error.values < np.radians(0.05))
            assert (row.ours is None) == bool(recovery.reason)
    # a wheel that runs down is waited for: its momentum falls by half in 42 s
    for case in ("Mx", "My", "Mz"):
        slow, quick = (
            claims[f"recover.lqr.{case}.{kind}.settle_s"].ours for kind in FAILURES[:0:-1]
        )
        assert slow > quick + 200.0


def test_the_limits_act_before_the_failure(runs):
    before = runs["lqr"].onset
    # the gain on theta is 1 N·m/rad, and theta is off by pi/2 - 0.8 with a rate of 0.04 rad/s
    assert before.demand > 0.5
    assert before.limited == pytest.approx(15.0, abs=0.05)
    strong = onset(laws().lqr, UNLIMITED)
    assert strong.limited == 0.0
    assert np.linalg.norm(strong.state.wheel_speed - before.state.wheel_speed) > 10.0


def test_the_drawing_has_a_line_for_every_recovery(runs):
    panels = recovery_drawing(runs).figure.axes
    assert len(panels) == 6
    for axes, case in zip(panels, CASES, strict=True):
        flown = sum(runs["lqr"].flown[case][kind].flight is not None for kind in FAILURES)
        # and the dotted line
        assert len(axes.lines) == 1 + 2 * flown
        assert len(axes.texts) == 6
