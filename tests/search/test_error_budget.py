"""Budget of the pointing error by source, against a linear loop that is solved by hand."""

import itertools
import json
from dataclasses import replace
from math import factorial

import numpy as np
import pytest

import gyrostat as gs
from benchmarks.error_budget import (
    AFTER,
    COUNT,
    EXAMPLES,
    INERTIA,
    KD,
    KP,
    PERIOD,
    RATE,
    SCENARIOS,
    SPREAD,
    TILT,
    TORQUE,
    wave_response,
    write_parts,
)
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.noise import noise_of
from gyrostat.core.errors import InputError
from gyrostat.scenario.error_sources import error_sources, never_switched, values_without
from gyrostat.search.budget_result import LAG, REST
from gyrostat.search.contributions import Sets, contributions, statistic_without
from gyrostat.search.error_budget import BudgetQuestion
from gyrostat.search.found_budget import budget_of

LINEAR = f"""
name = "linear"
{SCENARIOS["noise"]}
[[requirement]]
index = "RPE"
level = 0.95
value = "20 arcsec"
axis = "x"
window = "2 s"
instant = "end"
[[requirement]]
index = "PDE"
level = 0.9
value = "20 arcsec"
axis = "y"
window = "1 s"
stability = "5 s"
interpretation = "ensemble"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The linear scenario with what it names."""
    folder = tmp_path_factory.mktemp("linear")
    (folder / "linear.toml").write_text(LINEAR)
    write_parts(folder)
    return folder


@pytest.fixture(scope="module")
def flown(folder, tmp_path_factory):
    """Its budget, with the folder of the runs."""
    out = tmp_path_factory.mktemp("budget") / "runs"
    return gs.budget(folder / "linear.toml", out, runs=256, seed=3, metric="error_max"), out


def impulse_response(inertia, gain):
    """Attitude after a disturbed measurement: torque -gain in one period."""
    step = np.array([[1.0, PERIOD], [0.0, 1.0]])
    push = np.array([PERIOD**2 / 2.0, PERIOD]) / inertia
    closed = step - np.outer(push, [KP, KD])
    state, response = -gain * push, [0.0]
    for _ in range(COUNT):
        response.append(state[0])
        state = closed @ state
    return np.array(response)


def kernel(index):
    """Weights of the present and past errors in an index."""
    weights = np.zeros(40)
    if index == "APE":
        weights[0] = 1.0
        return weights
    window = {"RPE": 8, "PDE": 4}[index]
    mean = np.r_[0.5, np.ones(window - 1), 0.5] / window
    if index == "RPE":
        weights[0] = 1.0
        weights[: window + 1] -= mean
        return weights
    weights[: window + 1] += mean
    weights[20 : 20 + window + 1] -= mean
    return weights


def noise_variance(index, axis, gain, sigma):
    """Variance of an index from white noise of the measurement, rad²."""
    response = impulse_response(INERTIA[axis], gain)
    return sigma**2 * np.sum(np.convolve(response, kernel(index)) ** 2)


def wave_variance(index):
    """Variance of an index over time under the cosine."""
    weights = kernel(index)
    values = np.convolve(wave_response(), weights)[: COUNT + 1]
    last = np.flatnonzero(weights)[-1]
    return np.var(values[round(AFTER / PERIOD) + last :])


def analytic(index, axis):
    """Variance from each source, rad²."""
    truth = {
        "attitude noise": noise_variance(index, axis, KP, TILT),
        "rate noise": noise_variance(index, axis, KD, RATE),
        "external torque": 0.0,
        "environment.torque.wave": 0.0,
    }
    if axis == 0:
        truth["environment.torque.wave"] = wave_variance(index)
        # a constant torque turns by itself over the gain
        truth["external torque"] = (SPREAD / KP) ** 2 if index == "APE" else 0.0
    return truth


@pytest.mark.parametrize(("place", "index", "axis"), [(0, "APE", 0), (1, "RPE", 0), (2, "PDE", 1)])
def test_contributions_agree_with_the_linear_loop(flown, place, index, axis):
    split, truth = flown[0].indices[place].split, analytic(index, axis)
    assert {each.name for each in split.sources} == set(truth)
    floor = 1e-4 * split.whole.value  # the loop is linear to its small angles
    for each in (*split.sources, split.interaction):
        expected = truth.get(getattr(each, "name", ""), 0.0)
        estimate = getattr(each, "mean_square", each)
        # 2 times the half width of the interval of 95 %: four standard deviations
        assert abs(estimate.value - expected) <= (estimate.high - estimate.low) + floor
    constant = (TORQUE / KP) ** 2 if (index, axis) == ("APE", 0) else 0.0
    total = constant + sum(truth.values())
    assert abs(split.whole.value - total) <= (split.whole.high - split.whole.low) + floor
    assert abs(split.bias.value - constant) <= (split.bias.high - split.bias.low) + floor


def test_noise_is_estimated_within_a_few_percent(flown):
    split, truth = flown[0].indices[0].split, analytic("APE", 0)
    noise = {each.name: each.mean_square for each in split.sources}
    assert noise["attitude noise"].value == pytest.approx(truth["attitude noise"], rel=0.06)
    assert noise["rate noise"].value == pytest.approx(truth["rate noise"], rel=0.06)


def test_lines_add_up_to_the_whole(flown):
    for index in flown[0].indices:
        total = sum(line.mean_square.value for line in index.lines())
        assert total == pytest.approx(index.split.whole.value, rel=1e-12)
        assert sum(line.share.value for line in index.lines()) == pytest.approx(1.0, rel=1e-12)


def test_bias_belongs_to_the_constant_torque(flown):
    split = flown[0].indices[0].split
    bias = {each.name: each.bias[0] for each in split.sources}
    torque = bias["external torque"]
    assert abs(torque.value - TORQUE / KP) <= torque.high - torque.low
    assert split.lag_mean[0].value == pytest.approx(0.0, abs=1e-5 * TORQUE / KP)
    total = sum(each.value for each in bias.values()) + split.lag_mean[0].value
    assert total == pytest.approx(split.mean[0].value, rel=1e-6)


def test_draws_and_noise_stay_the_same_when_a_source_is_off(flown):
    """The mean error of every run is the sum of those of its sources alone."""
    import pyarrow.parquet as pq

    table = pq.read_table(flown[1] / "runs.parquet")
    mean = table["requirement.ape.mean.0"].to_numpy().reshape(-1, 256)
    whole, none, alone = mean[0], mean[1], mean[2:6]
    scale = np.std(alone, axis=1).max()
    np.testing.assert_allclose(whole, np.sum(alone, axis=0) - 3.0 * none, atol=1e-4 * scale)
    assert np.max(np.abs(none)) < 1e-5 * scale
    without = mean[6:10]
    np.testing.assert_allclose(whole - without, alone - none, atol=1e-4 * scale)
    assert np.min(np.max(np.abs(alone), axis=1)) > 1e-3 * scale


def test_runs_with_all_sources_have_the_draws_of_the_campaign(folder, flown):
    import pyarrow.parquet as pq

    scenario = gs.read_scenario(folder / "linear.toml")
    values, keys = draw(scenario, 3, np.arange(4))
    table = pq.read_table(flown[1] / "runs.parquet")
    np.testing.assert_array_equal(table[scenario.dispersed[0]].to_numpy()[:4], values[:, 0])
    parents, replaced = (table[name].to_numpy() for name in ("parent", "replaced"))
    runs = np.array([3, 256 + 3, 9 * 256 + 3])  # the same run with three sets of sources
    np.testing.assert_array_equal(noise_of(runs, parents, replaced, 3, 5), np.tile(keys[3], (3, 5)))


def test_files_text_and_picture(flown, folder):
    result, out = flown
    content = json.loads((out / "report.json").read_text())
    assert content["kind"] == "budget"
    assert [each["index"] for each in content["indices"]] == ["APE", "RPE", "PDE"]
    page = (out / "report.html").read_text()
    assert "attitude noise" in page
    assert "These numbers do not add up" in page
    assert "attitude noise" in str(result)
    assert "<img" in result._repr_html_()
    assert "error_max" in {each.metric for each in result.metrics}
    with pytest.raises(InputError, match="error budget"):
        gs.replay(out, 0)
    again = gs.report(out)
    assert again["indices"] == content["indices"]
    # a second call finds all runs
    same = gs.budget(folder / "linear.toml", out, runs=256, seed=3, metric="error_max")
    assert str(same) == str(result)


def test_mistakes_are_refused_in_one_line(folder, tmp_path):
    path = folder / "linear.toml"
    with pytest.raises(InputError, match=r"error_mx.*expected one of"):
        gs.budget(path, tmp_path / "a", metric="error_mx")
    with pytest.raises(InputError, match="runs: found 4, expected at least 16"):
        gs.budget(path, tmp_path / "a", runs=4)
    quiet = {
        "sensors.attitude_sigma": 0.0,
        "sensors.rate_sigma": 0.0,
        "environment.external_torque.x": 0.0,
        "environment.torque.wave.cosine.x": 0.0,
    }
    scenario = replace(gs.read_scenario(path), dispersions=()).replace(**quiet)
    with pytest.raises(InputError, match="found no source of pointing error"):
        gs.budget(scenario, tmp_path / "a")
    assert not (tmp_path / "a").exists()


def test_without_requirements_the_windows_are_split(folder):
    window = {"from": 50.0, "boresight": [0.0, 0.0, 1.0], "exposure": 2.0}
    scenario = gs.read_scenario(folder / "linear.toml")
    scenario = scenario.replace(windows={"imaging": window, "late": {"from": 60.0}})
    scenario = replace(scenario, requirements=())
    imaging = BudgetQuestion.of(scenario, 16, windows=["imaging"]).base.requirements
    assert [(e.index, e.axis, e.window, e.during) for e in imaging] == [
        ("APE", "half_cone", 0.0, ("imaging",)),
        ("RPE", "half_cone", 2.0, ("imaging",)),
    ]
    every = BudgetQuestion.of(scenario, 16).base.requirements
    assert [e.name for e in every] == ["ape_imaging", "rpe_imaging", "ape_late"]
    run = BudgetQuestion.of(scenario, 16, windows=["run"]).base.requirements
    assert [(e.name, e.during) for e in run] == [("ape", ())]
    with pytest.raises(InputError, match="window: found 'x', expected one of imaging, late, run"):
        BudgetQuestion.of(scenario, 16, windows=["x"])
    with pytest.raises(InputError, match="found it with pointing requirements"):
        BudgetQuestion.of(gs.read_scenario(folder / "linear.toml"), 16, windows=["run"])


def test_sources_are_the_numbers_that_differ_from_none():
    scenario = gs.read_scenario(EXAMPLES / "zero_crossing_model.toml")
    sources = {each.name: each for each in error_sources(scenario)}
    assert "friction, wheel.a" in sources
    assert sources["friction, wheel.a"].is_known
    assert "wheel.a.stribeck_speed" not in sources["friction, wheel.a"].keys
    assert not any("imbalance" in name for name in sources)
    assert never_switched(scenario) == []
    quiet = scenario.replace(**{"sensors.attitude_sigma": 0.0})
    assert "attitude noise" not in {each.name for each in error_sources(quiet)}


def test_events_are_sources_unless_something_needs_them():
    scenario = gs.read_scenario(EXAMPLES / "wheel_array.toml")
    assert [event.name for event in scenario.events] == ["turn", "loss"]
    sources = {each.name: dict(each.keys) for each in error_sources(scenario)}
    assert sources["event.loss"] == {"event.loss.time": 1e12}
    assert "event.turn" not in sources  # a slew is part of the reference
    assert never_switched(scenario) == []
    counted = scenario.replace(windows={"after": {"event": "loss", "from": 1.0}})
    assert never_switched(counted) == ["event.loss"]
    # the slew needs the order of the phases
    events = tuple(reversed(scenario.events))
    later = {"event.turn.time": scenario.values["event.loss.time"] + 100.0}
    swapped = replace(scenario, events=events, values={**scenario.values, **later})
    assert never_switched(swapped) == ["event.loss"]


def test_switched_values_keep_those_of_other_keys():
    scenario = gs.read_scenario(EXAMPLES / "zero_crossing_model.toml")
    friction = next(e for e in error_sources(scenario) if e.name == "friction, wheel.a")
    names = ["wheel.a.coulomb", "wheel.b.coulomb", "wheel.a.viscous", "wheel.a.static"]
    values = np.array([[2.0, 3.0, 4.0, 5.0]])
    np.testing.assert_allclose(
        values_without(names, values, [friction]), [[2e-6, 3.0, 4e-6, 5e-6]], rtol=1e-15
    )
    np.testing.assert_array_equal(values, [[2.0, 3.0, 4.0, 5.0]])


def game(rng, players, runs=50):
    """Errors of every set of sources of a bilinear system: mean square, mean, and the sources."""
    parts = rng.normal(size=(players, runs, 30)) + rng.normal(size=(players, 1, 1))
    return parts, 0.1 * rng.normal(size=(1, 30))


def moments(parts, lag, which):
    error = lag + np.sum(parts[[*which]], axis=0) if which else lag + np.zeros_like(parts[0])
    return np.mean(error**2, axis=1), np.mean(error, axis=1)


def test_contributions_are_shapley_values_of_a_linear_system():
    parts, lag = game(np.random.default_rng(1), 4)
    every = range(4)
    order = [tuple(every), (), *((k,) for k in every)]
    order += [tuple(j for j in every if j != k) for k in every]
    square, mean = (
        np.array(each) for each in zip(*(moments(parts, lag, s) for s in order), strict=True)
    )
    sets = Sets(tuple("abcd"), tuple(range(2, 6)), tuple(range(6, 10)))
    split = contributions(sets, square, mean[..., None])

    def variance(which):
        square, mean = moments(parts, lag, which)
        pairs = np.sum(mean) ** 2 - np.sum(mean**2)
        return np.mean(square) - pairs / (len(mean) * (len(mean) - 1))

    for k, each in enumerate(split.sources):
        others = [j for j in every if j != k]
        shapley = 0.0
        for size in range(4):
            weight = factorial(size) * factorial(3 - size) / factorial(4)
            for chosen in itertools.combinations(others, size):
                shapley += weight * (variance((*chosen, k)) - variance(chosen))
        assert each.mean_square.value == pytest.approx(shapley, rel=1e-9)
    assert split.interaction.value == pytest.approx(0.0, abs=1e-9)


def test_orders_share_out_all_interactions():
    """Three sources of which two only act together, and all three together add again."""
    rng, players = np.random.default_rng(4), range(3)
    subsets = [tuple(s) for k in range(4) for s in itertools.combinations(players, k)]
    order = [subsets[-1], (), *(s for s in subsets if 0 < len(s) < 3)]
    worth = {s: len(s) + 5.0 * (0 in s and 1 in s) + 7.0 * (len(s) == 3) for s in order}
    square = np.array([worth[s] * np.ones(30) for s in order]) + 1e-3 * rng.normal(size=30)
    places = {s: order.index(s) for s in order}
    chains = []
    for chain in [(0, 1, 2), (2, 1, 0), (1, 0, 2), (2, 0, 1), (0, 2, 1), (1, 2, 0)]:
        prefixes = [places[tuple(sorted(chain[:k]))] for k in range(4)]
        chains.append((chain, tuple(prefixes)))
    alone, without = (2, 3, 4), (places[(1, 2)], places[(0, 2)], places[(0, 1)])
    means = np.zeros((*square.shape, 1))
    every = contributions(Sets(("a", "b", "c"), alone, without, tuple(chains), True), square, means)
    expected = [1.0 + 2.5 + 7.0 / 3.0, 1.0 + 2.5 + 7.0 / 3.0, 1.0 + 7.0 / 3.0]
    values = [each.mean_square.value for each in every.sources]
    np.testing.assert_allclose(values, expected, rtol=1e-9)
    assert every.interaction.value == pytest.approx(0.0, abs=1e-9)
    picked = rng.integers(3, size=12)
    random = tuple(each for k in picked for each in chains[2 * k : 2 * k + 2])
    some = contributions(Sets(("a", "b", "c"), alone, without, random), square, means)
    for each, truth in zip(some.sources, expected, strict=True):
        assert each.mean_square.low <= truth <= each.mean_square.high
    single = contributions(Sets(("a", "b", "c"), alone, without), square, means)
    # 7 belongs to all three together; half of it is taken for each
    assert single.interaction.value == pytest.approx(7.0 - 3.0 * 3.5, rel=1e-9)


def test_orders_are_simulated_and_known_again(folder):
    scenario = gs.read_scenario(folder / "linear.toml")
    question = BudgetQuestion.of(scenario, 16, orders=32)
    assert question.places.is_every_order  # 24 orders of four sources
    assert len(question.places.orders) == 24
    # 16 subsets of the sources, and the dispersions at their nominal values
    assert len(question.sets) == 17
    again = BudgetQuestion.stored(question.scenario, question.options())
    named = [[each.name for each in s.off] for s in question.sets]
    assert [[each.name for each in s.off] for s in again.sets] == named
    few = BudgetQuestion.of(scenario, 16, orders=8)
    assert not few.places.is_every_order
    for order, places in few.places.orders:
        assert sorted(order) == [0, 1, 2, 3]
        assert (places[0], places[-1]) == (1, 0)
    with pytest.raises(InputError, match="orders: found 3, expected 0 or an even number"):
        BudgetQuestion.of(scenario, 16, orders=3)


def test_parts_of_a_user_name_their_source(folder):
    (folder / "torque.py").write_text(
        "import gyrostat as gs\nfrom typing import Annotated\nimport equinox as eqx\n"
        "import jax.numpy as jnp\n"
        "class Push(eqx.Module):\n"
        "    size: Annotated[float, gs.Key('N·m', source='leak')]\n"
        "    def __call__(self, spacecraft, attitude, time):\n"
        "        return self.size * jnp.ones(3)\n"
        "class Silent(eqx.Module):\n"
        "    size: Annotated[float, gs.Key('N·m')]\n"
        "    def __call__(self, spacecraft, attitude, time):\n"
        "        return self.size * jnp.ones(3)\n"
    )
    more = "".join(
        f'[[environment.torque]]\nname = "{name.lower()}"\npython = "torque.py:{name}"\n'
        "size = 1e-7\n"
        for name in ("Push", "Silent")
    )
    (folder / "user.toml").write_text(LINEAR + more)
    scenario = gs.read_scenario(folder / "user.toml")
    names = {each.name: dict(each.keys) for each in error_sources(scenario)}
    assert names["leak, environment.torque.push"] == {"environment.torque.push.size": None}
    assert never_switched(scenario) == ["environment.torque.silent"]


def test_intervals_cover_the_truth():
    rng, covered = np.random.default_rng(2), []
    sets = Sets(("a", "b"), (2, 3), (3, 2))
    for _ in range(400):
        parts = np.stack([rng.normal(size=(40, 20)), 0.5 * rng.normal(size=(40, 20)) + 0.3])
        order = [(0, 1), (), (0,), (1,)]
        square, mean = (
            np.array(each)
            for each in zip(*(moments(parts, np.zeros((1, 20)), s) for s in order), strict=True)
        )
        split = contributions(sets, square, mean[..., None])
        first, second = (each.mean_square for each in split.sources)
        covered.append(
            (
                first.low < 1.0 < first.high,
                second.low < 0.25 < second.high,
                split.bias.low < 0.09 < split.bias.high,
                split.whole.low < 1.34 < split.whole.high,
            )
        )
    share = np.mean(covered, axis=0)
    assert np.all((share > 0.91) & (share < 0.985))


def test_a_percentile_is_the_whole_minus_that_without_a_source():
    values = np.stack([np.arange(100.0), np.arange(100.0) / 2.0])
    whole, missing = statistic_without(values, 0.9, seed=0)
    assert whole.value == 89.0
    assert missing.value == 44.5
    assert missing.low < missing.value < missing.high
    assert statistic_without(values, None, seed=0)[1].value == pytest.approx(24.75)


def test_runs_that_fail_are_left_out_and_counted(folder):
    scenario = gs.read_scenario(folder / "linear.toml")
    question = BudgetQuestion.of(scenario, 40)
    rng = np.random.default_rng(0)
    columns = [name for group in question.columns().values() for name in group]
    response = rng.normal(size=(len(question.sets), 40, 1 + len(columns))) ** 2
    response[1, 3] = np.nan  # all sources off
    response[2, [3, 5]] = np.nan  # the first source alone
    result = budget_of(question, response, 0)
    assert result.valid == 38
    assert result.failed == {
        "with all sources off": 1,
        f"with {question.sources[0].name} alone": 2,
    }
    assert any("2 of 40 runs did not end" in text for text in result.remarks())
    assert result.doubts() == []
    assert not any("a rare event" in text for text in result.remarks())
    rare = response.copy()
    rare[0, 20, 1] *= 1e4
    assert any("a rare event" in text for text in budget_of(question, rare, 0).remarks())
    lacking = response.copy()
    lacking[1, 10, 1] = np.nan  # no value of the first requirement
    assert budget_of(question, lacking, 0).without == {"ape": 1}
    lacking[1, 10:, 1] = np.nan
    found = budget_of(question, lacking, 0)
    assert [index.requirement.index for index in found.indices] == ["RPE", "PDE"]
    assert found.doubts() == ["8 runs have values of ape with every set of sources"]
    response[0, :30] = np.nan
    assert budget_of(question, response, 0).doubts() == [
        "10 of 40 runs ended with every set of sources"
    ]
    assert {LAG, REST} <= {line.name for line in result.indices[0].lines()}
