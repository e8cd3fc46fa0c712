"""Worst case within bounds, and the pages of searches; flights are known functions."""

import html
import json

import numpy as np
import pytest
from scipy.special import ndtr

import gyrostat as gs
from gyrostat.campaigns import engine
from gyrostat.core.errors import InputError
from gyrostat.reports.worst_case import outcome
from gyrostat.search import tune, worst
from gyrostat.search.moves import FIRST, Answers
from gyrostat.search.worst import Bounds, fewest_flights, noise_share, worst_case
from gyrostat.search.worst_case import WorstCase

pytest.importorskip("cma", reason="the library of the extra search is not installed")


def searched(response, bounds, runs=3000, seed=1, allowed=lambda normal: normal[:, 0] > -np.inf):
    """Worst case of a function of standard normal numbers and of one of noise.

    Returns:
        The worst case, and the responses, normal numbers and noise of all runs, a row for each.
    """
    random, noise, rows = np.random.default_rng(seed), np.zeros(0), []
    search = worst_case(bounds, runs, seed)
    moves = next(search)
    while True:
        fine = allowed(moves.normal)
        fresh = (moves.parents < 0) | (moves.share == 1.0)
        drawn = random.standard_normal(moves.size)
        own = np.where(fresh, drawn, np.append(noise, 0.0)[moves.parents])
        value = response(moves.normal, own)
        rows.append(np.column_stack([value, moves.normal, own])[fine])
        numbers = np.where(fine, len(noise) + np.cumsum(fine) - 1, FIRST)
        noise = np.append(noise, own[fine])
        answers = Answers(numbers, moves.normal, np.where(fine, value, -np.inf))
        try:
            moves = search.send(answers)
        except StopIteration as end:
            assert len(noise) <= runs
            return end.value, np.concatenate(rows)


def normal_bounds(keys, sigma=3.0):
    return Bounds(np.zeros(keys, bool), sigma, False)


def test_the_worst_corner_is_found():
    weight = np.array([1.0, -2.0, 3.0, 0.5])
    found, _ = searched(lambda z, w: z @ weight, normal_bounds(4))
    assert found.response > 0.99 * 3.0 * np.sum(np.abs(weight))
    assert found.response > 1.2 * found.random
    np.testing.assert_allclose(found.coordinates, np.sign(weight), atol=0.1)
    loss = found.response - found.without
    np.testing.assert_allclose(loss, 3.0 * found.coordinates * weight, atol=1e-9)
    assert found.noise_share < 1e-6


def test_one_dispersion_is_enough():
    found, _ = searched(lambda z, w: -z[:, 0], normal_bounds(1))
    assert found.coordinates[0] < -0.99


def test_a_worst_case_inside_the_bounds_is_found():
    found, _ = searched(lambda z, w: -np.sum((z - 1.5) ** 2, axis=1), normal_bounds(3))
    np.testing.assert_allclose(found.coordinates, 0.5, atol=0.02)


def test_noise_that_drives_the_metric_is_seen():
    found, _ = searched(lambda z, w: w + 0.1 * z[:, 0], normal_bounds(2))
    assert found.noise_share > 0.85  # 300 pairs
    random = np.random.default_rng(0)
    values, one, two = random.standard_normal((3, 100_000))
    share = noise_share(2.0 * values + one, 2.0 * values + two)
    assert share == pytest.approx(0.2, abs=0.01)
    assert np.isnan(noise_share(np.ones(5), np.ones(5)))


def test_runs_that_end_early_are_the_worst():
    found, _ = searched(lambda z, w: np.where(z[:, 0] > 2.5, np.inf, z[:, 0]), normal_bounds(2))
    assert found.response == np.inf
    assert found.coordinates[0] > 2.5 / 3.0


RESPONSES = {
    "noise": lambda z, w: z[:, 0] + 2.0 * w,
    "best at the median": lambda z, w: np.abs(w) * np.sum(np.abs(z) < 1e-9, axis=1) + z[:, 0] * w,
    "ties": lambda z, w: np.round(z[:, 0] + w),
    "constant": lambda z, w: np.zeros(len(z)),
    "ends early": lambda z, w: np.where(z[:, 0] + w > 3.5, np.inf, z[:, 0]),
    "mostly missing": lambda z, w: np.where(w > 2.0, z[:, 1], -np.inf),
}


@pytest.mark.parametrize("response", RESPONSES.values(), ids=RESPONSES)
def test_the_worst_case_is_the_first_of_the_largest_responses_of_all_runs(response):
    bounds = Bounds(np.array([False, True, False]), 1.0, True)

    def allowed(normal):
        return normal[:, 2] > -0.3

    for seed in range(20):
        found, rows = searched(response, bounds, fewest_flights(3), seed, allowed)
        values, normal, noise = rows[:, 0], rows[:, 1:4], rows[:, 4]
        assert found.number == np.argmax(values)
        assert found.response == np.max(values)
        assert np.all(np.abs(bounds.coordinates(normal)) <= 1.0 + 1e-12)
        worst = normal[found.number]
        np.testing.assert_allclose(bounds.normal(found.coordinates[None])[0], worst, rtol=1e-9)
        # what the worst case would be with one value at its median, or nothing
        for key, without in enumerate(found.without):
            other = np.where(np.arange(3) == key, 0.0, worst)[None]
            expected = response(other, noise[[found.number]])[0]
            assert np.isnan(without) or without == expected


def test_independent_runs_are_drawn_within_the_bounds():
    """Truncated distributions have the variance that textbooks give."""
    for sigma, ends in ((0.8, False), (2.0, True)):
        bounds = Bounds(np.array([False, True]), sigma, ends)
        normal = bounds.draw(np.random.default_rng(1), 200_000)
        place = bounds.coordinates(normal)
        assert np.max(np.abs(place)) <= 1.0 + 1e-12
        density = np.exp(-0.5 * sigma**2) / np.sqrt(2.0 * np.pi)
        variance = 1.0 - 2.0 * sigma * density / (2.0 * ndtr(sigma) - 1.0)
        assert np.var(normal[:, 0]) == pytest.approx(variance, rel=0.01)
        assert np.var(place[:, 1]) == pytest.approx(1.0 / 3.0, rel=0.01)


def test_no_allowed_run_within_the_bounds_is_an_error():
    with pytest.raises(InputError, match="found no allowed run"):
        searched(RESPONSES["ties"], normal_bounds(2), allowed=lambda normal: normal[:, 0] > 9.0)


def test_bounds_of_a_box_are_the_ends_of_uniform_distributions():
    box = Bounds(np.array([True, False]), 3.0, True)
    np.testing.assert_allclose(box.normal(np.array([[1.0, 1.0]])), [[np.inf, 3.0]])
    sigma = box._replace(ends=False)
    np.testing.assert_allclose(sigma.normal(np.array([[1.0, -1.0]])), [[3.0, -3.0]])
    place = np.array([[0.3, -0.4]])
    for bounds in (box, sigma):
        np.testing.assert_allclose(bounds.coordinates(bounds.normal(place)), place, rtol=1e-12)


def test_bad_bounds_and_metrics_are_refused(scenario):
    for within in ("3", "9sigma", "sigma", "0sigma"):
        with pytest.raises(InputError, match="expected box or a number up to 8"):
            WorstCase.of(scenario, "error_max", within)
    with pytest.raises(InputError, match="expected one of"):
        WorstCase.of(scenario, "error", "box")
    with pytest.raises(InputError, match="expected at least"):
        WorstCase.of(scenario, "error_max", "box").searches(100, 0)


def test_a_worst_case_in_a_folder(scenario, fake_flights, tmp_path):
    said = []
    found = gs.campaign(
        scenario, 1000, tmp_path / "worst", worst_case="error_max", worst=0, say=said.append
    )
    assert found.worst == found.error_max[found.attrs["run"]] == found.error_max.max()
    assert found.noise_share == pytest.approx(0.5, abs=0.15)
    content = json.loads((tmp_path / "worst" / "report.json").read_text())
    assert content["values"][0]["key"] == "wheel.a.speed"
    assert content["values"][0]["place"] > 0.9
    page = (tmp_path / "worst" / "report.html").read_text()
    assert f"gyrostat replay {tmp_path / 'worst'} {found.attrs['run']}" in page
    assert any("wheel.a.speed at " in line for line in said)
    assert gs.report(tmp_path / "worst") == content
    noisy = gs.campaign(scenario, 1000, tmp_path / "n", worst_case="settling", worst=0)
    assert noisy.noise_share > 0.7  # 100 pairs
    assert "Noise drives settling" in (tmp_path / "n" / "report.html").read_text()


@pytest.mark.parametrize("kind", ["rare", "worst_case", "tune"])
def test_the_report_names_unlikely_numbers(scenario, fake_flights, tmp_path, kind):
    unlikely = scenario.replace(**{"wheel.a.torque_limit": 10.0})
    if kind == "tune":
        runs = tune.fewest_flights()
        gs.tune(unlikely, "controller.turn_gain", "error_max", tmp_path, runs=runs)
    else:
        asked = "error_max > 1" if kind == "rare" else "error_max"
        gs.campaign(unlikely, 4100, tmp_path, worst=0, **{kind: asked})
    lines = json.loads((tmp_path / "report.json").read_text())["unlikely"]
    assert any(line.startswith("unlikely: wheel.a.torque_limit: ") for line in lines)
    page = (tmp_path / "report.html").read_text()
    assert all(f'<p class="warning">{html.escape(line)}</p>' in page for line in lines)


def test_a_rare_failure_in_a_folder(scenario, fake_flights, tmp_path):
    said = []
    found = gs.campaign(
        scenario, 4100, tmp_path, rare="error_max > 1", worst=0, seed=3, say=said.append
    )
    assert any("20000 of 1e-6" in line for line in said)
    assert found.low < 1e-4 < found.high
    content = json.loads((tmp_path / "report.json").read_text())
    assert content["doubts"] == [*found.doubts]
    assert content["shared"][0]["key"] == "wheel.a.speed"
    # half of the failing sum of 3.95 standard deviations is due to the speed; the failures of a
    # replication of 20 chains descend from one or two runs
    assert content["shared"][0]["shift"] == pytest.approx(3.95 / np.sqrt(2.0), abs=0.6)
    failing = [each["run"] for each in content["failures"]]
    assert np.all(found.error_max[failing] > 1.0)
    with pytest.raises(InputError, match="expected the native engine"):
        gs.campaign(scenario, 4100, tmp_path, rare="error_max > 1", engine="jax")
    with pytest.raises(InputError, match="keep"):
        gs.campaign(scenario, 4100, tmp_path, rare="error_max > 1", keep=[1])


def test_a_search_that_was_stopped_anywhere_ends_like_another(scenario, fake_flights, tmp_path):
    options = {"worst_case": "error_max", "worst": 0, "seed": 3}
    whole = gs.campaign(scenario, 700, tmp_path / "whole", **options)
    pieces = [*(tmp_path / "whole" / "blocks").iterdir()]
    table = (tmp_path / "whole" / "runs.parquet").read_bytes()

    class StoppedError(Exception):
        pass

    def stop(done, total):
        if done > place:
            raise StoppedError

    for place in (0, 200, 500):
        folder = tmp_path / f"stopped-{place}"
        with pytest.raises(StoppedError):
            gs.campaign(scenario, 700, folder, on_progress=stop, **options)
        stored = len([*(folder / "blocks").iterdir()])
        assert 0 < stored < len(pieces)
        fake_flights.calls.clear()
        again = gs.campaign(scenario, 700, folder, **options)
        assert len(fake_flights.calls) == len(pieces) - stored
        assert again.attrs["run"] == whole.attrs["run"]
        assert (folder / "runs.parquet").read_bytes() == table
    assert whole.worst == whole.error_max.max()


def test_a_metric_that_no_run_has_gives_no_worst_case(
    scenario, fake_flights, tmp_path, monkeypatch
):
    def lacking(*given, **options):
        flown = fake_flights.fly(*given, **options)
        missing = np.full(len(flown.columns["run"]), np.nan)
        return flown._replace(columns=flown.columns | {"crossing_peak": missing})

    monkeypatch.setattr(engine, "fly_given", lacking)
    said = []
    found = gs.campaign(
        scenario, 700, tmp_path, worst_case="crossing_peak", worst=0, say=said.append
    )
    assert found.doubts == ("no run has the metric crossing_peak",)
    assert any("no crossing_peak" in line for line in said)
    content = json.loads((tmp_path / "report.json").read_text())
    assert content["worst"] is None
    assert content["doubts"] == [*found.doubts]
    page = (tmp_path / "report.html").read_text()
    assert "No worst case: no run has the metric crossing_peak" in page


def test_runs_of_another_version_of_the_search_are_refused(
    scenario, fake_flights, tmp_path, monkeypatch
):
    gs.campaign(scenario, 700, tmp_path, worst_case="error_max", worst=0)
    monkeypatch.setattr(worst, "FIRST_STEP", 0.3)
    with pytest.raises(InputError, match="use the version that started it"):
        gs.report(tmp_path)
    monkeypatch.setattr(worst, "INDEPENDENT", 12)
    with pytest.raises(InputError, match="use the version that started it"):
        gs.report(tmp_path)


@pytest.mark.parametrize(
    ("response", "metric", "text"),
    [
        (np.radians(0.5), "error_max", "0.5 deg"),
        (np.inf, "imaging.settling", "never settles"),
        (np.inf, "error_max", "ends early"),
        (-np.inf, "imaging.smear", "no imaging.smear"),
        (np.nan, "error_max", "not simulated"),
    ],
)
def test_a_response_that_is_no_number_is_told_with_its_reason(response, metric, text):
    assert outcome(response, metric, "rad") == text
