"""Gains found on common runs: known optima, limits, bounds, and the files of the verb."""

import json

import numpy as np
import pytest
from scipy.special import ndtr

import gyrostat as gs
from gyrostat.campaigns import engine
from gyrostat.campaigns.flown import Flown
from gyrostat.core.errors import InputError
from gyrostat.reports.tuning import front, front_figure
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search.condition import Condition
from gyrostat.search.moves import Answers
from gyrostat.search.tune import COMMON, _finalists, fewest_flights, tune
from gyrostat.search.tuning import Tuning, found_tuning

pytest.importorskip("cma", reason="the library of the extra search is not installed")
KEY = "controller.turn_gain"  # 0.4 in the scenario


@pytest.fixture
def gains(fake_flights, monkeypatch):
    """Error least at a gain of 0.8, torque in proportion to the gain, both scattered by a speed."""

    def fly(scenario, runs, values, keys, *, keep=()):
        columns = dict(fake_flights.fly(scenario, runs, values, keys).columns)
        gain = columns[KEY]
        scatter = np.exp(0.05 * (columns["wheel.a.speed"] - 3.0))
        columns["error_rms"] = scatter * (1.0 + np.log(gain / 0.8) ** 2)
        columns["torque_rms"] = scatter * gain
        return Flown(columns, None)

    monkeypatch.setattr(engine, "fly_given", fly)


def test_the_best_gain_is_found_and_written(folder, gains, tmp_path):
    said, runs = [], fewest_flights() + 8000
    path = folder / "scenario.toml"
    found = gs.tune(path, KEY, "error_rms", tmp_path, runs=runs, seed=1, say=said.append)
    assert found["values"][KEY] == pytest.approx(0.8, rel=0.02)
    # both have the same fresh runs, so that the ratio is exact
    assert found["ratio"] == pytest.approx(1.0 / (1.0 + np.log(2.0) ** 2), abs=1e-3)
    assert found["ratio_low"] == pytest.approx(found["ratio"], abs=1e-9)
    assert found["within_limits"]
    assert found["runs"] <= runs
    tuned = read_scenario(tmp_path / "tuned.toml")
    assert tuned.values == read_scenario(path).replace(**found["values"]).values
    assert json.loads((tmp_path / "report.json").read_text())["free"][0]["before"] == 0.4
    assert any("0.4 -> 0.8" in line or "0.4 -> 0.79" in line for line in said)
    # in a notebook: the candidates with the lowest value so far, and the sentences of the verb
    lowest = found.plot().axes[0].get_lines()[-1].get_ydata()
    assert np.nanmin(lowest) == lowest[-1]
    assert len(lowest) == found["candidates"]
    assert {*str(found).splitlines()} <= {*said}
    assert "data:image/png" in found._repr_html_()


def test_a_limit_holds_for_most_runs(scenario, gains, tmp_path):
    runs = fewest_flights() + 8000
    limit = "torque_rms < 0.6 N*m"
    found = gs.tune(scenario, {KEY: "0.1:2"}, "error_rms", tmp_path, subject_to=limit, runs=runs)
    torque = found["metrics"][1]["after"]
    assert 0.5 < torque < 0.6
    assert found["within_limits"]
    assert found["values"][KEY] < 0.6
    assert found["metrics"][1]["metric"] == "torque_rms"

    # the figure shows the tuned values, however far they are from most candidates
    stored = found_tuning(tmp_path)
    values = stored.tuned.values.copy()
    values[np.argmin(np.sum(np.abs(stored.tuned.tried - stored.tuned.best), axis=1))] = 2.0, 50.0
    shown = front_figure(stored._replace(tuned=stored.tuned._replace(values=values))).axes[0]
    assert shown.get_xlim()[0] < 0.6 < 50.0 < shown.get_xlim()[1]
    assert np.degrees(2.0) < shown.get_ylim()[1]


def test_candidates_of_the_last_comparison_have_margins_to_the_limits():
    value = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    assert _finalists(value, np.array([0.1, 0.0, -0.03, -0.5, -0.6])) == [1, 2, 3]
    assert _finalists(value, np.zeros(5)) == [0]
    assert _finalists(value, np.full(5, 0.1)) == []


def test_given_values_may_be_the_best(scenario, gains, tmp_path):
    said = []
    best = scenario.replace(**{KEY: 0.8})
    gs.tune(best, KEY, "error_rms", tmp_path, runs=fewest_flights(), say=said.append)
    assert any("as good as any found" in line for line in said)


@pytest.mark.parametrize(
    ("free", "limit", "message"),
    [
        ({"controller.gain": None}, (), "expected one of .*turn_gain"),
        ({"run.control_period": None}, (), "--free: found 'run.control_period'"),
        ({"wheel.a.speed": None}, (), "which is dispersed"),
        ({"body.inertia.xx": None}, (), "--free: found 'body.inertia.xx', expected one of"),
        ({KEY: "1:2"}, (), "expected the value of the scenario, 0.4, within them"),
        ({KEY: "1"}, (), "expected LOW:HIGH"),
        ({KEY: None}, ("torque_rms < 1 rpm",), "found unit 'rpm'"),
        ({}, (), "--free: found none"),
    ],
)
def test_bad_options_are_refused(scenario, free, limit, message):
    with pytest.raises(InputError, match=message):
        Tuning.of(scenario, free, "error_rms", limit)


def test_coordinates_are_logarithmic_between_positive_bounds(scenario):
    question = Tuning.of(scenario, {KEY: None}, "error_rms", ())
    np.testing.assert_allclose(
        question.numbers(np.array([[-1.0], [0.0], [1.0]]))[:, 0], [0.1, 0.4, 1.6]
    )
    np.testing.assert_allclose(question._start(), 0.0, atol=1e-12)


def test_the_front_has_what_no_other_beats():
    values = np.array([[1.0, 5.0], [2.0, 5.0], [2.0, 3.0], [3.0, 4.0], [4.0, 1.0], [1.0, 6.0]])
    np.testing.assert_array_equal(front(values), [1, 0, 1, 0, 1, 0])


def test_given_values_that_are_better_on_the_last_runs_are_kept():
    """Common runs favour a candidate that is worse on all others."""

    def share(coordinates):
        return 0.5 + 0.5 * coordinates

    search = tune(np.zeros(1), share, lambda value: 0.0, fewest_flights(), 1)
    moves, first = next(search), 0
    while True:
        normal = np.zeros((moves.size, 2)) if moves.normal is None else moves.normal
        place = 2.0 * ndtr(normal[:, -1]) - 1.0
        is_common = (moves.parents >= 0) & (moves.parents < COMMON)
        numbers, first = first + np.arange(moves.size), first + moves.size
        metric = 1.0 + np.where(is_common, -np.abs(place), np.abs(place))
        try:
            moves = search.send(Answers(numbers, normal, -metric[:, None]))
        except StopIteration as end:
            found = end.value
            break
    assert first <= fewest_flights()
    assert found.values[0, 0] > np.min(found.values)
    np.testing.assert_array_equal(found.best, found.start)


def test_a_metric_that_most_runs_lack_is_no_result(scenario, gains, tmp_path, monkeypatch):
    fly = engine.fly_given

    def early(*given, **options):
        flown = fly(*given, **options)
        status = (np.arange(len(flown.columns["run"])) % 5 == 0).astype(np.int8)
        return Flown(flown.columns | {"status": status}, None)

    monkeypatch.setattr(engine, "fly_given", early)
    said = []
    found = gs.tune(scenario, KEY, "error_rms", tmp_path, runs=fewest_flights(), say=said.append)
    assert found["doubts"] == ["5 % or more of the runs end early or have no error_rms"]
    assert found["metrics"][0]["after"] is None
    assert not any("none" in line for line in said)


def test_the_response_is_each_metric_with_its_sign():
    limits = (Condition("low", False, 2.0, "low < 2"), Condition("high", True, 1.0, "high > 1"))
    question = Tuning({"k": (-1.0, 3.0), "p": (0.1, 10.0)}, (0.0, 1.0), "least", limits)
    columns = {"least": [3.0, 5.0], "low": [1.0, 4.0], "high": [7.0, np.nan], "status": [0, 0]}
    found = question.response({name: np.array(values) for name, values in columns.items()})
    np.testing.assert_array_equal(found, [[-3.0, -1.0, 7.0], [-5.0, -4.0, -np.inf]])
    # beyond a limit in shares of it; `value` has the signs of the response turned
    assert question.excess(np.array([0.0, 3.0, -4.0])) == pytest.approx(0.5)
    assert question.excess(np.array([0.0, 1.0, -0.25])) == pytest.approx(0.75)
    # linear where a bound is not positive, logarithmic where both are
    ends = question.numbers(np.array([[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]))
    np.testing.assert_allclose(ends, [[-1.0, 0.1], [1.0, 1.0], [3.0, 10.0]])
