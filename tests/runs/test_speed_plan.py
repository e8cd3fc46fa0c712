"""Plans of wheel speeds: search, certificate, flight."""

import itertools
import re
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy.stats import binomtest

import gyrostat as gs
from gyrostat.campaigns.flown import Flown
from gyrostat.core.units import RPM
from gyrostat.microvibration import (
    Harmonic,
    ModalModel,
    MountedWheel,
    WheelDisturbance,
    line_of_sight,
)
from gyrostat.reports.speed_plan import content_of, lines_of, page_of
from gyrostat.runs.speed_plan.choices import Certificate, Choice, Leaf, Problem, infeasible, solve
from gyrostat.runs.speed_plan.demand import Limits, demand_of
from gyrostat.runs.speed_plan.flight import crossings, distance
from gyrostat.runs.speed_plan.problems import intervals
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search import speed_plan
from gyrostat.simulation import Status

EXAMPLES = Path(__file__).parents[2] / "examples" / "scenarios"
PYRAMID = np.array([[1.0, -1.0, -1.0, 1.0], [1.0, 1.0, -1.0, -1.0], [1.0, 1.0, 1.0, 1.0]]) / 3**0.5
MODEL = ModalModel(np.array([20.0]), np.array([0.01]), np.ones((1, 1, 6)), np.ones((1, 2)))
MOUNTED = MountedWheel(
    "a", WheelDisturbance("a", (Harmonic(1.0, {"force": 1e-9}),)), PYRAMID[:, 0], np.zeros(3)
)
WHEELS = Limits(
    PYRAMID,
    np.full(4, 2e-5),
    np.full(4, 0.01),
    np.full(4, 1e-3),
    np.array([[200.0, 230.0]]),
    np.array([1.0, -1.0, 1.0, -1.0]),
    0.2,
    5e-6,
    0.02,
    np.diag([0.05, 0.06, 0.07]),
)


def test_intervals_are_what_a_fine_grid_of_speeds_allows():
    found = intervals(WHEELS, 0, 10.0) / 2e-5
    grid = np.linspace(-520.0, 520.0, 4001)
    size = np.abs(grid)
    allowed = (size > 10.0) & ((size < 190.0) | (size > 240.0)) & (size < 490.0)
    inside = np.any([(low < grid) & (grid < high) for low, high in found], axis=0)
    np.testing.assert_array_equal(inside, allowed)


def random_problem(generator):
    """Two variables, a few rows, and choices of two intervals for single rows."""
    choices = tuple(
        Choice(row[None, :], q * np.ones(1), q * np.ones(1), np.array([[-1.0, -0.4], [0.4, 1.0]]))
        for row, q in zip(generator.normal(size=(4, 2)), generator.normal(size=4), strict=True)
    )
    matrix, bound = generator.normal(size=(3, 2)), generator.uniform(0.1, 1.0, 3)
    return Problem(matrix, bound, np.full(2, 2.0), choices)


def feasible_by_enumeration(problem):
    from scipy.optimize import linprog

    for made in itertools.product(*(range(len(each.intervals)) for each in problem.choices)):
        matrix, bound = problem.relaxed(made)
        if linprog(np.zeros(2), A_ub=matrix, b_ub=bound, bounds=[(-2, 2)] * 2).status == 0:
            return True
    return False


def test_search_agrees_with_enumeration_and_its_certificates_hold():
    answers = []
    for seed in range(40):
        problem = random_problem(np.random.default_rng(seed))
        truth, proof = feasible_by_enumeration(problem), infeasible(problem)
        point, ended = solve(problem, np.ones(2))
        assert ended
        assert (point is not None) == truth
        assert isinstance(proof, Certificate) == (not truth)
        if isinstance(proof, Certificate):
            assert proof.proves(problem)
        answers.append(truth)
    assert 5 < sum(answers) < 35


def test_a_certificate_with_a_leaf_less_or_other_weights_proves_nothing():
    problems = (random_problem(np.random.default_rng(seed)) for seed in range(40))
    problem, proof = next(
        (p, c)
        for p in problems
        if isinstance(c := infeasible(p), Certificate) and len(c.leaves) > 2
    )
    assert not Certificate(proof.leaves[1:]).proves(problem)
    first = proof.leaves[0]
    other = Leaf(first.made, np.ones_like(first.weights))
    assert not Certificate((other, *proof.leaves[1:])).proves(problem)


def test_crossings_count_only_within_windows():
    speed = np.array([[5.0], [1.0], [-1.0], [-5.0], [5.0], [21.0], [19.0], [21.0]])
    inside = np.array([1, 1, 1, 0, 1, 1, 1, 1], bool)
    assert crossings(speed, inside, np.array([[20.0, 25.0]])) == {"zero": 1, "band": 2}


def test_distance_is_that_of_the_worst_wheel_from_zero_bands_and_limits():
    bands = WHEELS._replace(bands=np.array([[200.0, 230.0]]))
    safe = np.array([[50.0, -120.0, 300.0, -400.0]])
    assert distance(safe, bands) == pytest.approx(50.0)
    for speed, expected in ((-190.0, 10.0), (240.0, 10.0), (210.0, -10.0), (-497.0, 3.0)):
        assert distance(np.vstack([safe, [speed, *safe[0, 1:]]]), bands) == pytest.approx(expected)


LATE = """
[[event]]
name = "late"
kind = "slew"
time = "100 s"
target = [0.8660254, 0.0, 0.0, 0.5]

[[dispersion]]
key = "event.late.time"
distribution = "uniform"
low = "50 s"
high = "399 s"
"""


class Histories(NamedTuple):
    """Histories of runs with the same signals."""

    signals: dict[str, Any]

    def of_run(self, _number):
        return self

    def arrays(self):
        return self.signals


def test_a_dispersed_run_counts_in_its_own_windows_only(mission, monkeypatch):
    """Wheels cross zero at 200 s; the window is from 10 s to 40 s after an event at `times`."""
    from_event = '[{ name = "science", event = "late", from = "10 s", until = "40 s" }]'
    text = MISSION.replace('[{ name = "science", from = "100 s" }]', from_event)
    mission.write_text(text + LATE)
    scenario = read_scenario(mission)
    count = scenario.count + 1
    speed = np.linspace(20.0, -20.0, count)[:, None] + np.zeros(4)
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    histories = Histories(
        {"attitude": attitude, "rate": np.zeros((count, 3)), "wheel_speed": speed}
    )
    times = np.array([100.0, 180.0, 200.0, 395.0, 180.0])
    status = np.array([*4 * [Status.COMPLETE], Status.DIVERGED])
    columns = {"event.late.time": times, "status": status}
    flown = Flown(columns, histories)
    monkeypatch.setattr(speed_plan, "fly", lambda *_arguments, **_options: flown)
    found = speed_plan._dispersed(scenario, ["science"], WHEELS, 5, 0, "jax", None)
    assert [is_clean for is_clean, _ in found] == [True, False, True, None, False]


BAND = """
[[controller.band]]
name = "resonance"
above = 30.0
below = 40.0
[[dispersion]]
key = "controller.band.resonance.above"
distribution = "uniform"
low = 10.0
high = 35.0
"""


def test_a_dispersed_run_is_judged_by_its_own_bands(mission, monkeypatch):
    """At 25 rad/s all the time, a wheel is in the band only where that begins below."""
    mission.write_text(MISSION + BAND)
    scenario = read_scenario(mission)
    count = scenario.count + 1
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    signals = {"attitude": attitude, "rate": np.zeros((count, 3))}
    histories = Histories({**signals, "wheel_speed": np.full((count, 4), 25.0)})
    ends = np.array([28.0, 22.0])
    columns = {"controller.band.resonance.above": ends, "status": np.zeros(2, int)}
    flown = Flown(columns, histories)
    monkeypatch.setattr(speed_plan, "fly", lambda *_arguments, **_options: flown)
    found = speed_plan._dispersed(scenario, ["science"], WHEELS, 2, 0, "jax", None)
    assert [is_clean for is_clean, _ in found] == [True, False]


MISSION = """name = "drift"
[run]
duration = "400 s"
control_period = "0.5 s"
[spacecraft]
file = "cubesat.toml"
[start]
wheel_speed = [-45.0, -36.0, -17.0, -162.0]
[controller]
kind = "wheel_array"
target = [1.0, 0.0, 0.0, 0.0]
[environment]
external_torque = ["24.5 µN·m", "-30.7 µN·m", "5 µN·m"]
[metrics]
window = [{ name = "science", from = "100 s" }]
"""


@pytest.fixture
def mission(tmp_path):
    for name in ("cubesat.toml", "cubesat_wheel.toml"):
        (tmp_path / name).write_text((EXAMPLES / name).read_text())
    path = tmp_path / "mission.toml"
    path.write_text(MISSION)
    return path


def test_a_plan_appended_to_its_scenario_flies_without_crossings(mission, tmp_path):
    result = gs.plan_speeds(mission, tmp_path / "out")
    assert result.answer == "found"
    assert sum(result.before.values()) > 0
    planned = tmp_path / "planned.toml"
    planned.write_text(MISSION + (tmp_path / "out" / "plan.toml").read_text())
    assert read_scenario(planned) == result.scenario
    assert result.after == {"zero": 0, "band": 0}
    assert result.planned.distance > result.clearance > result.present.distance
    check_pages(result)
    check_picture(result)


def check_picture(result):
    """The picture has the wheel speeds by both laws; nothing unloads in them."""
    panels = result.plot().axes
    names = ("present law", "with the plan")
    flights = (result.present, result.planned)
    for axes, name, flight in zip(panels, names, flights, strict=True):
        assert axes.get_title("left") == f"wheel speed (rpm), {name}"
        drawn = [line.get_ydata() for line in axes.get_lines() if line.get_label()[0] != "_"]
        speed = flight.speed / RPM
        assert len(drawn) == speed.shape[1]
        ends = [(np.min(each), np.max(each)) for each in drawn]
        np.testing.assert_allclose(ends, np.transpose([speed.min(axis=0), speed.max(axis=0)]))
        assert axes.collections  # the science windows
    assert str(result).splitlines() == lines_of(result)
    assert "data:image/png" in result._repr_html_()


def check_pages(result):
    """Statistics, JSON and page of a result, with counted runs of a campaign."""
    counted = replace(result, runs=64, clean_before=0, clean_after=60)
    share, low, high = counted.probability()
    interval = binomtest(60, 64).proportion_ci(method="exact")
    assert (share, low, high) == pytest.approx((60 / 64, interval.low, interval.high))
    content, lines = content_of(counted), lines_of(counted)
    assert content["probability"] == [share, low, high]
    assert content["probability_present"][:2] == [0.0, 0.0]
    assert "93.8 % (84.8 to 98.3 %) with the plan" in lines[-1]
    partly = replace(counted, outside_before=64, outside_after=2)
    assert lines_of(partly)[-1].endswith(": 64 by the present law, 2 with the plan")
    assert "unknown by the present law, 96.8 % (" in lines_of(partly)[-2]
    assert content_of(partly)["probability_present"] is None
    assert content_of(partly)["probability"][0] == pytest.approx(60 / 62)
    page = page_of(counted, "command")
    charts = re.findall(r'<svg class="chart" .*?</svg></svg>|<svg class="chart".*?</svg>', page)
    assert "93.8 % (84.8 to 98.3 %)" in page
    assert page.count('class="cells avoided"') > 2
    assert sum("wheel speed (rpm)" in chart for chart in charts) == 2
    sight = line_of_sight([MOUNTED], MODEL, np.array([10.0, 400.0]), 0.1, limit=1e-6)
    seen = replace(
        counted,
        sight=sight,
        present=result.present._replace(sight=2e-6),
        sight_before=(2e-6, np.nan) * 32,
        sight_after=(5e-7,) * 64,
    )
    (line,) = [each for each in lines_of(seen) if "line of sight" in each]
    assert "0.4125 arcsec (0 % (0 to 5.6 %) of the runs within 0.2063 arcsec) by the" in line
    assert "unknown: wheels above its speeds (100 % (94.4 to 100 %) of the runs" in line
    assert content_of(seen)["line_of_sight"]["runs_present"][:2] == [2e-6, None]


def test_a_drift_across_zero_that_nothing_can_avoid_is_proven(mission):
    hard = {"environment.external_torque.x": 6e-5}
    result = gs.plan_speeds(mission, **hard)
    assert result.answer == "infeasible"
    assert result.plan.certificate is not None
    assert result.plan.certificate.proves(result.plan.problem)


def test_entries_of_a_plan_must_be_in_order(mission):
    rows = "".join(
        f'[[controller.plan]]\nname = "{name}"\ntime = {time}\nnull_space = 0.0\n'
        for name, time in (("a", 20.0), ("b", 10.0))
    )
    mission.write_text(MISSION + rows)
    with pytest.raises(gs.InputError, match=r"controller.plan\[b\].time: found 10 s, expected mo"):
        gs.check(mission)


def test_another_unloading_is_refused(mission):
    rods = """[unloading]
kind = "torque_rods"
limit = [0.1, 0.1, 0.1]
[[sensor]]
kind = "magnetometer"
[[actuator]]
kind = "torque_rods"
limit = [0.1, 0.1, 0.1]
[orbit]
kind = "circular"
epoch = "2026-06-21T10:12:00Z"
altitude = "500 km"
inclination = "97.4 deg"
"""
    mission.write_text(MISSION + rods)
    with pytest.raises(gs.InputError, match="key unloading: found torque_rods, expected none"):
        gs.plan_speeds(mission)


def test_demand_without_unloading_does_not_depend_on_the_actuator():
    """The same body, once with and once without a constant torque of its actuator."""
    count, period, torque = 11, 0.5, np.array([1e-6, -2e-6, 3e-6])
    attitude = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    inside = np.ones(count, bool)
    speed = np.tile([100.0, -50.0, 70.0, 20.0], (count, 1))
    impulse = period * np.arange(count)[:, None] * torque
    total = speed @ (PYRAMID * 2e-5).T
    rate = np.zeros((count, 3))
    still = {"attitude": attitude, "rate": rate, "wheel_speed": speed, "momentum": total}
    unloaded = {
        "attitude": attitude,
        "rate": rate,
        "wheel_speed": speed + impulse @ np.linalg.pinv(PYRAMID).T / 2e-5,
        "momentum": total + impulse,
        "external_torque": np.tile(torque, (count, 1)),
    }
    first, second = (demand_of(each, inside, period, WHEELS) for each in (still, unloaded))
    np.testing.assert_allclose(first.wheels, second.wheels, atol=1e-15)
    np.testing.assert_allclose(first.total, second.total, atol=1e-15)
    assert first.windows == second.windows == ((0, count, 0),)


def test_a_scenario_without_windows_is_refused(mission):
    mission.write_text(MISSION.partition("[metrics]")[0])
    with pytest.raises(gs.InputError, match="found no"):
        gs.plan_speeds(mission)
