"""Probability of a rare failure: known probabilities, storage, replay, and answers with doubts.

The flights are functions of the drawn values and of the noise whose distribution is known.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtr, ndtri
from typer.testing import CliRunner

import gyrostat as gs
from gyrostat.campaigns import engine, replay
from gyrostat.campaigns.draws import draw, noise_keys, shares, values_at
from gyrostat.campaigns.executors import threads
from gyrostat.campaigns.flown import Flown
from gyrostat.campaigns.noise import noise_of, parts_of
from gyrostat.campaigns.store import Store
from gyrostat.cli import app
from gyrostat.core.errors import InputError
from gyrostat.search import execute, rare, tune, worst
from gyrostat.search.condition import Condition
from gyrostat.search.estimate import interval, rarity
from gyrostat.search.moves import Answers
from gyrostat.search.subset import subset_simulation

KEY = "wheel.a.speed"  # the dispersed value that matters to `fake_flights`
WIDE = {"COLUMNS": "400", "TERM": "dumb"}
MILLIONTH = -ndtri(1e-6)


def searched(response, size=2, chains=97, count=rare.REPLICATIONS, seed=0):
    """Replications of a search whose response is a function of standard normal numbers."""
    found = []
    for number in range(count):
        random = np.random.default_rng([seed, number, 1])
        search, first = subset_simulation(chains, [seed, number]), 0
        moves = next(search)
        while True:
            numbers = first + np.arange(moves.size)
            first += moves.size
            normal = moves.normal
            normal = random.standard_normal((moves.size, size)) if normal is None else normal
            try:
                moves = search.send(Answers(numbers, normal, response(normal)))
            except StopIteration as end:
                found.append(end.value)
                break
    return found


@pytest.mark.parametrize(
    "response",
    [
        lambda z: z[:, 0] - MILLIONTH,
        lambda z: np.sum(z, axis=1) / np.sqrt(2.0) - MILLIONTH,
        lambda z: np.abs(z[:, 0]) + ndtri(0.5e-6),
        lambda z: np.sum(z**2, axis=1) + 2.0 * np.log(1e-6),
    ],
    ids=["one", "sum", "two sides", "all around"],
)
def test_a_probability_of_one_in_a_million(response):
    found = rarity(searched(response))
    assert found.low < 1e-6 < found.high
    assert not found.doubts
    assert found.variation < 0.5


def test_steps_adapt_to_the_wanted_acceptance():
    levels = searched(lambda z: z[:, 0] - MILLIONTH, size=5)[0].levels
    assert 0.3 < np.mean([level.accepted for level in levels[2:]]) < 0.55


def test_an_interval_of_equal_estimates_is_a_point_and_covers_the_mean_of_skewed_ones():
    np.testing.assert_allclose(interval(np.full(5, 2e-6)), 2e-6, rtol=1e-9)
    random = np.random.default_rng(1)
    skewed = np.exp(0.6 * random.standard_normal((2000, 10)) - 0.18) * 1e-6  # mean 1e-6
    ends = np.array([interval(row) for row in skewed])
    assert np.mean((ends[:, 0] < 1e-6) & (ends[:, 1] > 1e-6)) == pytest.approx(0.95, abs=0.02)


def test_an_interval_of_estimates_that_agree_by_chance_has_the_width_that_their_chains_explain():
    logs = np.array([-0.5, -0.3, 0.0, 0.2, 0.6])
    explained, middle = np.var(logs, ddof=1), np.exp(np.mean(logs))
    wide = interval(np.exp(logs))
    np.testing.assert_allclose(interval(np.full(5, middle), explained), wide, rtol=1e-9)
    np.testing.assert_allclose(interval(np.exp(logs), 0.1 * explained), wide, rtol=1e-9)


def test_failures_in_a_narrow_band_of_one_number_have_doubts_and_an_interval_that_covers():
    # few independent flights are in the band; the second number announces the failure anywhere
    def band(z):
        return z[:, 1] + 2.5 * (np.abs(z[:, 0] + 2.2) < 0.05) - 5.4

    inside = ndtr(-2.15) - ndtr(-2.25)
    truth = inside * ndtr(-2.9) + (1.0 - inside) * ndtr(-5.4)
    found = [rarity(searched(band, seed=seed)) for seed in range(6)]
    assert all(each.doubts for each in found)
    answers = [each for each in found if each.probability is not None]
    assert len(answers) >= 3  # twice the replications with half the chains: none
    assert all(each.low < truth < each.high for each in answers)


def test_a_missed_failure_region_raises_doubts():
    # the gentle slope of one number ends at a wall; the failures are up the steep one of the other
    def wall(z):
        return np.maximum(np.minimum(z[:, 0] - 4.7, -1.2), 3.0 * (z[:, 1] - 4.7))

    assert all(rarity(searched(wall, seed=seed)).doubts for seed in range(3))


def test_a_metric_that_cannot_fail_has_no_probability():
    found = rarity(searched(lambda z: np.minimum(z[:, 0], 2.0) - 3.0))
    assert (found.probability, found.low, found.high) == (None, None, None)
    assert "does not come closer" in found.doubts[0]
    far = rarity(searched(lambda z: z[:, 0] - 8.0))
    assert far.probability is None
    assert "end before the failure" in far.doubts[0]
    # the metric is at most 2 in all of the independent runs
    assert 1e-4 < found.below < 2e-3


@pytest.mark.parametrize("truth", [1e-8, 1e-9])
def test_a_failure_that_is_not_reached_is_rarer_than_the_limit(truth):
    found = [rarity(searched(lambda z: z[:, 0] + ndtri(truth), seed=k)) for k in range(10)]
    missed = [each for each in found if each.probability is None]
    assert missed
    assert all(truth < each.below < 1e-6 for each in missed)
    assert all(each.below is None for each in found if each not in missed)


def test_frequent_failures_need_no_levels():
    found = rarity(searched(lambda z: z[:, 0] + 1.0))
    assert found.low < ndtr(1.0) < found.high


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("error_max >= 1 deg", "expected METRIC > VALUE"),
        ("error_max", "expected METRIC > VALUE"),
        ("error_most > 1 deg", "expected one of error_p95|expected one of error_p50"),
        ("error_max > 1 rpm", "expected a unit of angle"),
        ("saturated > much", "expected a number in 1"),
    ],
)
def test_bad_conditions_are_refused(scenario, text, message):
    with pytest.raises(InputError, match=message):
        Condition.parse(text, scenario, "--rare")


def test_conditions_have_units_and_a_direction(scenario):
    above = Condition.parse(" error_max > 0.5 deg", scenario, "--rare")
    assert (above.metric, above.above, above.text) == ("error_max", True, "error_max > 0.5 deg")
    assert above.bound == pytest.approx(np.radians(0.5))
    assert Condition.parse("saturated<2 %", scenario, "").bound == pytest.approx(0.02)
    columns = {"error_max": np.array([0.0, np.nan, 1.0]), "status": np.array([0, 0, 1])}
    np.testing.assert_array_equal(above.response(columns), [-np.radians(0.5), -np.inf, np.inf])
    assert above.missing(columns) == 1


def test_noise_is_inherited_part_by_part():
    parents = np.array([-1, -1, 0, 2, 1])
    share = np.array([1.0, 1.0, 0.3, 0.3, 0.0])
    keys = noise_of(np.arange(5), parents, share, 7, 1000)
    own = [int(noise_keys(7, number)) for number in range(5)]
    assert np.all(keys[0] == own[0])  # the noise of an ordinary run
    assert np.all(keys[4] == own[1])
    assert set(keys[2].tolist()) == {own[0], own[2]}
    assert np.mean(keys[2] == own[2]) == pytest.approx(0.3, abs=0.05)
    assert set(keys[3].tolist()) == {own[0], own[2], own[3]}
    assert np.all((keys[3] == own[3]) | (keys[3] == keys[2]))


def test_values_are_functions_of_uniform_numbers(scenario):
    values, _ = draw(scenario, 3, np.arange(4))
    np.testing.assert_array_equal(values_at(scenario, shares(scenario, 3, np.arange(4))), values)


def test_a_search_is_stored_resumed_and_replayed(scenario, fake_flights, tmp_path, monkeypatch):
    flown = fake_flights.calls

    def search(failure, **further):
        question = rare.RareFailure(Condition.parse(failure, scenario, "--rare"))
        execute.run_search(
            scenario, tmp_path, question, execute.Options(4100, 3, worst=0), **further
        )

    search("error_max > 1 rad")
    found, count = rare.found_failures(tmp_path), sum(flown)
    assert found.rarity.low < 1e-4 < found.rarity.high
    assert 2500 < count == len(found.columns["run"]) < 4100
    np.testing.assert_array_equal(found.columns["run"], np.arange(count))
    before = (tmp_path / "runs.parquet").read_bytes()

    # the first flights are runs of a campaign
    drawn = draw(scenario, 3, np.arange(9))[0][:, scenario.dispersed.index(KEY)]
    np.testing.assert_array_equal(found.columns[KEY][:9], drawn)

    store = Store(tmp_path)
    failing = int(np.argmax(found.columns["error_max"]))
    assert failing > 500
    monkeypatch.setattr(Store, "write_history", lambda *given: given[2])
    monkeypatch.setattr(engine, "fly_given", lambda *given, keep: _kept(fake_flights.fly(*given)))
    assert replay(store, store.known(), [failing], threads(1)) == [failing]

    blocks = sorted((tmp_path / "blocks").iterdir())
    blocks[0].write_bytes(b"damage")
    blocks[-1].unlink()
    (tmp_path / "runs.parquet").unlink()
    flown.clear()
    said = []
    search("error_max > 1 rad", say=said.append)
    assert sum(flown) < 0.5 * count
    assert (tmp_path / "runs.parquet").read_bytes() == before
    assert any("damaged block" in line for line in said)
    with pytest.raises(InputError, match="another search"):
        search("error_max > 2 rad")
    assert parts_of(scenario) == 121
    with pytest.raises(InputError, match=r"found a search, expected a campaign with \[\[requirem"):
        gs.report(tmp_path, check=True)


class _Anything:
    def of_run(self, run):
        return run


def _kept(flown):
    return Flown(flown.columns, _Anything())


def test_runs_are_spent_on_few_replications_with_many_chains_and_too_few_are_refused():
    for runs, chains in ((4100, 20), (20_000, 97)):
        searches = rare.searches_of(runs, 0)
        assert len(searches) == 5
        assert next(searches[0]).size == chains * 5  # five runs of a chain
    with pytest.raises(InputError, match="expected at least 4100"):
        rare.searches_of(4099, 0)


def test_the_help_of_the_command_line_has_the_least_numbers_of_runs(scenario):
    runner = CliRunner()
    texts = {
        verb: " ".join(runner.invoke(app, [verb, "--help"], env=WIDE).output.split())
        for verb in ("campaign", "tune")
    }
    assert "in --runs or less: at least 4100, which suit 1e-2" in texts["campaign"]
    keys = len(scenario.dispersed)
    few, each = worst.FEWEST, worst.FEWEST_OF_KEY
    assert f"at least {few}, and {each} more for each dispersed value" in texts["campaign"]
    assert f"Largest number of runs, at least {tune.fewest_flights()}" in texts["tune"]
    assert worst.fewest_flights(keys) == few + each * keys
    with pytest.raises(InputError, match=f"at least {few + each * keys} with worst_case and"):
        gs.campaign(scenario, 50, worst_case="error_max")
    with pytest.raises(InputError, match="found 50, expected at least 4100 with rare"):
        gs.campaign(scenario, 50, rare="error_max > 1 deg")
    with pytest.raises(InputError, match=f"at least {tune.fewest_flights()} with tune"):
        gs.tune(scenario, "controller.turn_gain", "error_max", "unused", runs=50)
    assert not Path("unused").exists()


def test_advice_on_the_number_of_runs_is_given_for_a_possible_search_only(scenario, tmp_path):
    for runs, failure in ((100, "error_max > 1 deg"), (4100, "error_most > 1 deg")):
        said = []
        with pytest.raises(InputError):
            gs.campaign(scenario, runs, tmp_path, rare=failure, say=said.append)
        assert not [line for line in said if not line.startswith("unlikely: ")]
