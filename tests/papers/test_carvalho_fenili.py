"""Carvalho and Fenili: the whole reproduction against scipy and a loop written apart."""

import functools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_are
from scipy.spatial.transform import Rotation

from gyrostat.core.jax64 import jnp
from gyrostat.papers.carvalho_fenili import CARVALHO_FENILI, figures, recoveries, statements
from gyrostat.papers.carvalho_fenili.laws import gain, laws, rank
from gyrostat.papers.carvalho_fenili.torque_driven import (
    BodyTorqueCommand,
    EulerSensor,
    EulerState,
    TorqueDrivenBody,
)
from gyrostat.papers.reproduction import Run
from gyrostat.simulation import simulate

CASES = ("none", "Mx", "My", "Mz", "MxMy", "MxMz", "MyMz")
FAILED = {"Mx": [0], "My": [1], "Mz": [2], "MxMy": [0, 1], "MxMz": [0, 2], "MyMz": [1, 2]}
FAILURES = ("frozen", "seized", "rundown")
H0 = np.array([0.58895, 0.04587, 0.81442])
# 3-1-3 angles phi 0, theta pi/2, psi 0
TARGET = Rotation.from_euler("x", 0.5 * np.pi)
Q = np.diag([50.0, 50.0, 10.0, 10.0, 10.0, 10.0])
R = np.diag([50.0, 100.0, 100.0])
START = np.array([0.8, 0.04, 0.7, 0.04, 0.6, 0.04])
GOAL = np.array([0.5 * np.pi, 0.0, 0.0, 0.0, 0.0, 0.0])


def pair(x):
    """A and B of (17) and (18), corrected by hand, over theta, theta', phi, phi', psi, psi'."""
    t, td, _, _, p, sd = x
    s, c = np.sin(t), np.cos(t)
    a = np.zeros((6, 6))
    a[0, 1] = a[2, 3] = a[4, 5] = 1.0
    a[1, 3] = -sd * s
    a[3, 3], a[3, 5] = -td * c / s, td / s
    a[5, 1], a[5, 3] = -sd * c / s, td / s
    b = np.zeros((6, 3))
    b[1] = np.cos(p), -np.sin(p), 0.0
    b[3] = np.sin(p) / s, np.cos(p) / s, 0.0
    b[5] = -np.sin(p) * c / s, -np.cos(p) * c / s, 1.0
    return a, b / 12.0


def gain_at(x):
    a, b = pair(x)
    return np.linalg.solve(R, b.T @ solve_continuous_are(a, b, Q, R))


def torque(law, x):
    return -(linear_gain() if law == "lqr" else gain_at(x)) @ (x - GOAL)


@functools.cache
def linear_gain():
    return gain_at(GOAL)


def field(x, moment):
    """(5) by way of the body rate: its derivative is M / I, and no formula of (5) is used."""
    t, td, _, pd, p, sd = x
    turn = np.array(
        [
            [np.cos(p), np.sin(t) * np.sin(p), 0.0],
            [-np.sin(p), np.sin(t) * np.cos(p), 0.0],
            [0.0, np.cos(t), 1.0],
        ]
    )
    turn_rate = np.array(
        [
            [-np.sin(p) * sd, np.cos(t) * td * np.sin(p) + np.sin(t) * np.cos(p) * sd, 0.0],
            [-np.cos(p) * sd, np.cos(t) * td * np.cos(p) - np.sin(t) * np.sin(p) * sd, 0.0],
            [0.0, -np.sin(t) * td, 0.0],
        ]
    )
    bend = np.linalg.solve(turn, moment / 12.0 - turn_rate @ [td, pd, sd])
    return np.array([td, bend[0], pd, bend[1], sd, bend[2]])


def flown_apart(law, failed, end):
    works = np.array([0.0 if axis in failed else 1.0 for axis in range(3)])
    options = {"method": "DOP853", "rtol": 1e-8, "atol": 1e-10}
    before = solve_ivp(lambda _, x: field(x, torque(law, x)), (0.0, 15.0), START, **options)
    after = solve_ivp(
        lambda _, x: field(x, works * torque(law, x)), (15.0, end), before.y[:, -1], **options
    )
    return after.y[:, -1] - GOAL


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


class Sampled:
    """A law of the paper as a sampled controller, its torque held through the period."""

    def __init__(self, law):
        self.law = law

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        state = EulerState(*measurement.angles, *measurement.rates)
        return memory, BodyTorqueCommand(self.law(state))


@pytest.fixture(scope="module")
def flown(quick):
    """All cases by both laws, as the quick run simulated them."""
    return quick("carvalho-fenili").run.once(statements.flown)


@pytest.fixture(scope="module")
def linear(flown):
    return flown["lqr"]


@pytest.fixture(scope="module")
def judged(flown):
    """Judge statements on given runs: id -> whether it holds."""

    def judge(experiment, flights):
        return experiment(Run(True, print, {statements.flown: flights})).values

    return judge


@pytest.fixture(scope="module")
def healthy(quick):
    """Runs up to the failure on healthy wheels by law, without and with limits."""
    return quick("carvalho-fenili").run.once(recoveries.before_failure)


@pytest.fixture(scope="module")
def onset(healthy):
    """State at the failure under LQR on wheels with limits."""
    return recoveries.at_failure(healthy["lqr"])[1]


@pytest.fixture(scope="module")
def recovered(onset):
    """Every recovery under LQR, by case and kind of loss."""
    return recoveries.recovered(onset, dict.fromkeys(FAILED, FAILURES))


def test_the_gain_and_the_ranks_are_those_of_scipy():
    np.testing.assert_allclose(gain(), linear_gain(), rtol=0.0, atol=1e-9)
    # closed forms of a double integrator with inertia 12
    assert gain()[0, :2] == pytest.approx([1.0, np.sqrt((50.0 + 2 * 12.0 * 50.0) / 50.0)])
    assert gain()[1, 2:4] == pytest.approx(
        [np.sqrt(0.1), np.sqrt((10.0 + 2 * 12.0 * np.sqrt(10.0 * 100.0)) / 100.0)]
    )
    for case in CASES:
        assert rank(case) == 6 if case == "none" else 6 - 2 * (len(case) // 2)


@pytest.mark.parametrize(("case", "failed"), [("none", ()), ("Mz", (2,)), ("MyMz", (1, 2))])
def test_lqr_flies_as_when_integrated_apart(linear, case, failed):
    expected = flown_apart("lqr", failed, 60.0)
    row = 6000
    np.testing.assert_allclose(linear[case].angles[row], expected[::2], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(linear[case].rates[row], expected[1::2], rtol=0.0, atol=1e-6)


def test_sdre_flies_as_when_integrated_apart_and_holding_changes_little(flown):
    flight = flown["sdre"]["MxMy"]
    expected = flown_apart("sdre", (0, 1), 20.0)
    np.testing.assert_allclose(flight.angles[2000], expected[::2], rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(flight.rates[2000], expected[1::2], rtol=0.0, atol=1e-6)
    plant = TorqueDrivenBody(12.0, jnp.array([15.0, 15.0, np.inf]))
    sampled = simulate(
        plant,
        Sampled(laws()["sdre"]),
        EulerSensor(),
        start=EulerState(*START[[0, 2, 4, 1, 3, 5]]),
        duration=20.0,
        control_period=0.01,
    )
    angles = np.stack([sampled.theta - 0.5 * np.pi, sampled.phi, sampled.psi], axis=1)
    apart = np.max(np.abs(angles - flight.angles[:2001]))
    # half a sample late: rates of 0.1 rad/s times 0.005 s
    assert 1e-5 < apart < 1e-3


def test_the_rates_about_failed_axes_are_frozen_and_the_runs_end_where_they_must(linear):
    for case in CASES[1:]:
        flight = linear[case]
        assert flight.frozen_rate_drift(flight.resolved_until) < 1e-5
        assert np.linalg.norm(flight.frozen_rate()) > 0.01
    x = linear["Mx"]
    # phi and psi settled, theta goes on at the frozen rate until its sine is 0.005
    late = x.time > 60.0
    slope = np.polyfit(x.time[late], x.angles[late, 0], 1)[0]
    assert slope == pytest.approx(float(x.frozen_rate()[0]), rel=1e-4)
    left = (x.angles[6000, 0] + 0.5 * np.pi - 0.005) / -slope
    assert x.valid_until == pytest.approx(60.0 + left, abs=0.1)
    assert not x.complete
    spun = linear["MxMz"]
    assert spun.resolved_until == pytest.approx(64.9, abs=0.2)
    assert spun.resolved_until < spun.valid_until < 71.0


def test_statements_are_judged_on_the_runs_not_by_their_names(flown, judged):
    honest = judged(statements.linear, flown)
    assert not honest["lqr.MyMz.all_angles_controlled"]
    assert not honest["lqr.My.failure_compensated"]
    assert honest["lqr.Mx.theta_unstable"]
    # a run that does settle, in the place of the failures, turns the verdicts round
    settled = {law: dict.fromkeys(CASES, runs["none"]) for law, runs in flown.items()}
    swapped = judged(statements.linear, settled)
    assert swapped["lqr.MyMz.all_angles_controlled"]
    assert not swapped["lqr.Mx.theta_unstable"]


def test_sdre_freezes_rates_too_and_ends_where_halved_steps_end(flown):
    dependent = flown["sdre"]
    for case in CASES[1:]:
        flight = dependent[case]
        assert flight.frozen_rate_drift(flight.resolved_until) < 1e-4
    # halved steps of a loop written apart end at 192.715 s
    assert dependent["MyMz"].valid_until == pytest.approx(192.71, abs=0.02)


def test_on_wheels_one_failure_leaves_rest_possible(flown, healthy):
    # on wheels nothing is taken from the body's momentum
    state, _ = recoveries.at_failure(healthy["sdre"])
    # pieces as long as the runs before the failure, and as many runs: the same compiled program
    law, plants = [recoveries.EitherLaw(np.array(True))] * 4, [recoveries.failing("Mx", 0.0)] * 4
    for _ in range(12):
        run = recoveries.fly_on_wheels(law, plants, 15.0, each=True, begin=state)
        state, _ = recoveries.at_failure(run)
    rate = np.linalg.norm(run.rate.values[0, -1])
    assert rate < 1e-3 < np.linalg.norm(flown["sdre"]["Mx"].frozen_rate())


def test_the_figures_have_their_panels(flown, judged):
    drawings = statements.drawn(Run(True, print, {statements.flown: flown})).drawings
    assert "Figs. 9, 10, 21, 22" in drawings[5].title
    assert [len(drawing.figure.axes) for drawing in drawings] == [4] * 7 + [12]


@pytest.mark.slow
def test_a_quick_run_judges_every_claim_as_published(judged_as_published, quick):
    judged_as_published("carvalho-fenili")
    assert quick("carvalho-fenili").page.count('<div class="charts') == 8


def test_the_total_momentum_is_that_of_table_2():
    np.testing.assert_allclose(recoveries.start().momentum, H0, atol=5e-6)


def test_what_can_be_held_follows_from_the_momentum_at_the_failure(onset, recovered):
    turn = Rotation.from_quat(np.roll(onset.attitude, -1))
    # H = R (I w + J s): the body rate, and with it what a rotor holds in inertial space
    relative = 0.01 * np.asarray(onset.wheel_speed)
    rate = (turn.inv().apply(H0) - relative) / 12.0
    assert np.max(np.abs(relative)) < 3.0
    for case, failed in FAILED.items():
        for failure in FAILURES:
            kept = np.zeros(3)
            if failure == "frozen":
                kept[failed] = (relative + 0.01 * rate)[failed]
            expected = nearest(H0, failed, kept)
            answer = recovered[case][failure].plan.answer
            if expected is None:
                assert answer.angle is None
                # J is 11.99 without the rotors, and what is left over must turn with the body
                over = np.linalg.norm(kept) - np.linalg.norm(H0)
                assert answer.for_ever.rate == pytest.approx(over / 11.99, rel=1e-3)
            else:
                assert np.degrees(answer.angle) == pytest.approx(expected, abs=2e-3)
                assert answer.for_ever.rate == 0.0


def test_every_recovery_settles_or_says_why(recovered):
    for case, failed in FAILED.items():
        for failure in FAILURES:
            recovery = recovered[case][failure]
            settle = recovery.settle
            if recovery.plan.answer.angle is None:
                assert settle is None
                assert "no attitude is feasible" in recovery.reason
            elif len(failed) == 1:
                assert 0.0 < settle < 600.0
                late = recovery.flight.time.values >= settle
                assert np.all(recovery.flight.error.values[late] < np.radians(0.05))
                assert np.all(np.abs(recovery.flight.rate.values[late]) < 1e-4)
                assert not np.all(recovery.flight.error.values < np.radians(0.05))
            assert (settle is None) == bool(recovery.reason)
            # the claims are those of the recoveries that come to no rest
            assert (settle is None) == (failure in recoveries.WITHOUT_REST.get(case, ()))
    # a wheel that runs down is waited for: its momentum falls by half in 42 s
    for case in ("Mx", "My", "Mz"):
        slow, quick = (recovered[case][kind].settle for kind in FAILURES[:0:-1])
        assert slow > quick + 200.0


def test_the_limits_act_before_the_failure(healthy, onset):
    run = healthy["lqr"]
    before = run.isel(run=1, time=slice(None, 150))
    # the gain on theta is 1 N·m/rad, and theta is off by pi/2 - 0.8 with a rate of 0.04 rad/s
    assert np.max(np.abs(before.torque)) > 0.5
    assert 0.1 * np.sum(np.any(before.saturated.values, axis=1)) == pytest.approx(15.0, abs=0.05)
    free = run.wheel_momentum.values[0, 150]
    assert np.linalg.norm(free - 0.01 * onset.wheel_speed) > 0.1


def test_the_figure_has_a_line_for_every_recovery(recovered):
    panels = figures.recovery_figure(dict.fromkeys(("lqr", "sdre"), recovered)).figure.axes
    assert len(panels) == 6
    for axes, case in zip(panels, FAILED, strict=True):
        flights = [recovered[case][kind].flight for kind in FAILURES]
        # and the dotted line
        assert len(axes.lines) == 1 + 2 * sum(flight is not None for flight in flights)
        assert len(axes.texts) == 6


def test_requirements_and_end_of_the_full_run_have_their_rows():
    full = {row.id for row in CARVALHO_FENILI.rows if row.full}
    assert sum(name.startswith("goals.") for name in full) == 2 * (4 + 7) + 2
    assert "gyrostat.lqr.MxMy.pointing_error" in full
