"""Pointing requirements: reading, statistics and verdicts."""

from collections import namedtuple
from math import comb
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.campaigns.pointing.campaign import PointingBudget
from gyrostat.campaigns.pointing.collected import Collected, counted_sizes
from gyrostat.campaigns.pointing.statistics import least_runs, mean_bounds, size_at
from gyrostat.campaigns.pointing.verdicts import judged
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.reports import requirements
from gyrostat.runs.metrics.error_vectors import across_and_about, error_vector
from gyrostat.scenario.metrics.sample import Sample
from gyrostat.scenario.requirement import KNOWLEDGE, ErrorSignal, Requirement
from gyrostat.scenario_files.scenario_file import read_scenario
from gyrostat.search.error_budget import moment_columns

ANGLE = np.pi / 180.0


@pytest.fixture(scope="module")
def write(folder):
    """Write the small scenario with other requirements; returns its path."""
    text = (folder / "scenario.toml").read_text()
    start = text.index("[[requirement]]")
    head, tail = text[:start], text[start:]
    tail = tail[tail.index("[[dispersion]]") :]

    def written(*rows):
        path = folder / "required.toml"
        path.write_text(head + "\n".join(f"[[requirement]]\n{row}" for row in rows) + "\n" + tail)
        return path

    return written


def test_a_requirement_is_read_with_its_defaults(write):
    path = write(
        'index = "RPE"\nwindow = "1 s"\nlevel = 0.997\nvalue = "5 arcsec"',
        'name = "drift"\nindex = "PDE"\nwindow = 2\nstability = 3\nlevel = 0.9\nvalue = 1e-3\n'
        'axis = "x"\ninterpretation = "temporal"\nduring = "imaging"\nshare = 0.8',
    )
    first, second = read_scenario(path).requirements
    boresight = (1.0, 0.0, 0.0)
    assert first == Requirement(
        "rpe", "RPE", 5 * ANGLE / 3600, 0.997, "mixed", "half_cone", boresight, 1.0
    )
    assert second.during == ("imaging",)
    path = write('index = "APE"\nlevel = 0.9\nvalue = 1\nduring = "imaging"')
    assert read_scenario(path).requirements[0].boresight == (0.0, 1.0, 0.0)
    assert (second.share, second.stability, second.boresight) == (0.8, 3.0, None)
    again = read_scenario(path).replace(requirements=[{"index": "APE", "level": 0.5, "value": 1.0}])
    assert [each.name for each in again.requirements] == ["ape"]
    assert type(again).from_text(again.text()) == again


APE = 'index = "APE"\nlevel = 0.9\nvalue = "1 deg"\n'
MPE = 'index = "MPE"\nlevel = 0.9\nvalue = "1 deg"\n'
PDE = 'index = "PDE"\nlevel = 0.9\nvalue = "1 deg"\n'
PRE = 'index = "PRE"\nlevel = 0.9\nvalue = "1 deg"\nwindow = "1 s"\n'


@pytest.mark.parametrize(
    ("rows", "found"),
    [
        ([APE.replace("APE", "JPE")], "index: found 'JPE', expected one of APE, MPE"),
        ([APE.replace("0.9", "1.0")], "level: found 1.0, expected a probability below 1"),
        ([APE.replace("0.9", "99.7")], "level: found 99.7, expected above 0, at most 1"),
        ([APE.replace("0.9", '"100 %"')], "level: found '100 %', expected a probability below 1"),
        ([APE.replace("0.9", '"much %"')], "level: found 'much %', expected a percentage"),
        ([APE.replace("1 deg", "-1 deg")], "value: found '-1 deg', expected above 0"),
        ([APE.replace("1 deg", "1 s")], "found unit 's', expected a unit of angle"),
        ([APE, APE], "name: found 'ape', expected a unique name"),
        ([APE + 'windo = "1 s"'], "did you mean"),
        ([APE + 'window = "1 s"'], "window: found '1 s', expected none: APE does not have it"),
        ([APE + "share = 0.5"], "share: found 0.5, expected none: mixed does not have it"),
        ([APE + 'estimate = "attitude"'], "estimate: found 'attitude', expected none"),
        ([APE + 'axis = "x"\nboresight = [0, 0, 1]'], "boresight: found [0, 0, 1], expected none"),
        ([APE + 'during = ["imaging", "turning"]'], "its windows have different boresights"),
        ([APE + 'axis = "roll"'], "axis: found 'roll', expected one of x, y, z"),
        ([APE + 'during = "sleeping"'], "during: found 'sleeping', expected windows of the metric"),
        ([MPE], "window: found none, expected above 0, in s"),
        ([MPE + 'window = "1.1 s"'], "window: found 1.1, expected a whole multiple of the control"),
        ([MPE + 'window = "29 s"'], "29 s of MPE to fit in an observation period of 28 s"),
        ([PDE + 'window = "2 s"'], "stability: found none"),
        ([PDE + 'window = "2 s"\nstability = "1 s"'], "stability: found '1 s', expected at least"),
        ([PRE], "during: found None, expected windows of the metrics"),
        ([PRE + 'interpretation = "temporal"'], "expected ensemble or mixed"),
        (
            [PRE.replace("PRE", "RPE").replace("1 s", "0.75 s") + 'instant = "centre"'],
            "expected an even number of control periods",
        ),
    ],
)
def test_what_cannot_be_is_refused(write, rows, found):
    with pytest.raises(InputError) as caught:
        read_scenario(write(*rows))
    assert found in str(caught.value)
    assert "\n" not in str(caught.value)


def test_levels_and_shares_may_be_percentages(write):
    row = APE.replace("0.9", '"99.7 %"') + 'interpretation = "temporal"\nshare = "90 %"'
    (requirement,) = read_scenario(write(row)).requirements
    assert (requirement.level, requirement.share) == (0.997, 0.9)


def test_other_windows_may_not_take_those_of_a_requirement(scenario):
    keys = [d for d in scenario.dispersions if d.keys[0].startswith("start")]
    with pytest.raises(InputError, match="during: found 'imaging', expected one of other"):
        scenario.replace(windows={"other": {"from": 1.0}}, dispersions=tuple(keys))


def test_the_error_is_resolved_across_and_about_a_boresight():
    """Angles of any size, by rotations that are made of them."""
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    across = np.cross(axis, [0.3, 0.5, -0.1])
    across *= 1.1 / np.linalg.norm(across)
    for tilt, about in ((across, 0.7), (1e-9 * across, -1e-9), (0.0 * across, -2.0)):
        turn = Rotation.from_rotvec(tilt) * Rotation.from_rotvec(about * axis)
        quaternion = turn.as_quat(canonical=True, scalar_first=True)
        found = across_and_about(jnp.asarray(quaternion), jnp.asarray(axis))
        np.testing.assert_allclose(found, tilt + about * axis, rtol=1e-9, atol=1e-16)


def test_the_knowledge_error_is_that_of_the_named_estimate_or_of_the_best_one():
    """Estimate of a controller before the measurement; what is no quaternion is refused."""
    names = namedtuple("Measurement", "attitude"), namedtuple("Command", "estimated_attitude")
    turns = Rotation.from_rotvec([[0.0, 0.0, 0.02], [0.0, 0.01, 0.0]])
    quaternions = turns.as_quat(canonical=True, scalar_first=True)
    parts = [name(jnp.asarray(each)) for name, each in zip(names, quaternions, strict=True)]
    state = SimpleNamespace(attitude=jnp.array([1.0, 0.0, 0.0, 0.0]))
    record = namedtuple("Record", "rate")(jnp.zeros(3))
    sample = Sample(0.0, 0.0, None, None, None, {}, state, *parts, record)
    for estimate, expected in ((None, [0.0, 0.01, 0.0]), ("attitude", [0.0, 0.0, 0.02])):
        found = error_vector(ErrorSignal(KNOWLEDGE, None, estimate), sample)
        np.testing.assert_allclose(found, expected, atol=1e-15)
    for name in ("rate", "luck"):
        with pytest.raises(InputError, match=f"estimate: found '{name}', expected a quaternion"):
            error_vector(ErrorSignal(KNOWLEDGE, None, name), sample)


def test_the_least_number_of_runs_of_a_level():
    for level in (0.5, 0.9, 0.997, 0.999999):
        count = least_runs(level)
        assert level**count <= 0.025 < level ** (count - 1)


@pytest.mark.parametrize(("count", "share"), [(20, 0.5), (100, 0.97), (100, 0.03)])
def test_the_interval_of_a_mean_covers_for_binary_values(count, share):
    """Exact coverage over all outcomes; binary values have the largest spread."""
    covered = 0.0
    for inside in range(count + 1):
        low, high = mean_bounds(inside / count, count)
        chance = comb(count, inside) * share**inside * (1 - share) ** (count - inside)
        covered += chance if low <= share <= high else 0.0
    assert covered >= 0.95


def test_the_size_at_a_level_is_interpolated():
    sizes = np.array([1.0, 2.0, 4.0])
    assert size_at(0.75, np.array([0.2, 0.5, 1.0]), sizes) == pytest.approx(2.0 * 2.0**0.5)
    assert size_at(0.1, np.array([0.2, 0.5, 1.0]), sizes) == 1.0
    assert np.isnan(size_at(0.9, np.array([0.2, 0.5, 0.8]), sizes))


def test_verdicts_cover_their_level_in_simulated_campaigns():
    """Campaigns whose true level is the required one pass in at most 2.5 % and fail as seldom."""
    random = np.random.default_rng(0)
    required = Requirement("r", "APE", 1.0, 0.9, "ensemble")
    verdicts = []
    for _ in range(600):
        # the size that 90 % of the runs do not exceed is 1
        metric = random.uniform(size=200) / 0.9
        verdicts.append(judged(required, metric, np.zeros(200)).verdict)
    assert verdicts.count("pass") < 0.025 * 600 + 3 * 4
    assert verdicts.count("fail") < 0.025 * 600 + 3 * 4
    assert verdicts.count("not decided") > 540


def mixed(sizes, level, value=1.0, status=None):
    """Verdict on a mixed requirement, of the sizes of runs, (runs, samples)."""
    required = Requirement("r", "APE", value, level, "mixed")
    shares = np.mean(sizes[:, :, None] <= counted_sizes(value) * value, axis=1)
    status = np.zeros(len(sizes)) if status is None else status
    metric = np.where(status == 0, np.mean(sizes > value, axis=1), np.nan)
    return judged(required, metric, status, shares[status == 0].sum(axis=0))


def test_a_mixed_size_is_that_of_all_runs_and_times_together():
    random = np.random.default_rng(1)
    sizes = np.abs(random.normal(size=(2000, 200)) * random.uniform(0.2, 0.6, size=(2000, 1)))
    found = mixed(sizes, 0.95)
    assert found.size.value == pytest.approx(np.quantile(sizes, 0.95), rel=0.005)
    assert found.size.low < found.size.value < found.size.high < 1.0
    assert found.verdict == "pass"
    assert found.margin.low == pytest.approx(1.0 - found.size.high)
    assert mixed(sizes, 0.95, value=0.5).verdict == "fail"
    assert mixed(sizes, 0.95, value=found.size.value).verdict == "not decided"


def flown(requirement, sizes):
    """Verdict on a mixed requirement of errors about x of these sizes, (runs, samples)."""
    runs, samples = sizes.shape
    collected = Collected(requirement, runs, 1.0, samples, group=runs, masks=1)
    vectors = np.stack([sizes, np.zeros(sizes.shape), np.zeros(sizes.shape)], axis=-1)
    collected.add(vectors, [np.ones(sizes.shape, bool)])
    collected.finish()
    shares = collected.counts()[:, :-1] / samples
    return judged(requirement, collected.metric(), np.zeros(runs), shares.sum(axis=0))


@pytest.mark.parametrize("value", [1e-6, 5e-6, 1e-3, 0.3, 3.0])
@pytest.mark.parametrize("far", [0.02, 0.9, 3.0, 50.0, 1e5])
def test_a_mixed_size_is_found_however_far_it_is_from_the_value(value, far):
    """Against the quantile of all errors together; no error is above half a turn."""
    random = np.random.default_rng(3)
    scale = np.pi * random.uniform(0.5, 1.0, size=(400, 1)) * random.uniform(size=(400, 100))
    sizes = scale * min(far * value / np.pi, 1.0)
    for level in (0.5, 0.95):
        found = flown(Requirement("r", "APE", value, level, "mixed"), sizes)
        expected = np.quantile(sizes, level, method="inverted_cdf")
        assert found.size.value == pytest.approx(expected, rel=0.01)
        assert found.size.low < expected <= found.size.high < 2.0 * expected
        assert found.margin.value == pytest.approx(1.0 - found.size.value / value)
        assert not found.is_limit
        is_above = found.size.low > value
        assert (found.verdict == "pass") == (found.size.high <= value)
        assert found.verdict == "fail" or not is_above


def test_errors_of_half_a_turn_are_found():
    found = flown(Requirement("r", "APE", 1e-5, 0.9, "mixed"), np.full((100, 2), np.pi))
    assert found.size.low < np.pi <= found.size.high
    assert found.size.value == pytest.approx(np.pi, rel=0.05)


def test_a_size_below_all_counted_ones_is_a_limit():
    found = flown(Requirement("r", "APE", 1.0, 0.9, "mixed"), np.full((100, 2), 1e-5))
    assert found.is_limit
    assert found.size == (1.0 / 256.0, 0.0, 1.0 / 256.0)
    assert requirements.size_text(requirements.content(found)) == "at most 0.2238 deg"


def test_a_missed_requirement_is_shown_with_its_size_by_few_runs():
    """30 runs cannot show 99.7 %, but that half of them exceed the value."""
    sizes = np.repeat([0.5, 5.0], 15)[:, None]
    found = mixed(sizes, 0.997)
    assert (found.verdict, found.runs < found.needed) == ("fail", True)
    assert found.size.value == pytest.approx(5.0, rel=0.05)
    line = requirements.line(requirements.content(found))
    assert "95 % confidence: at least" in line
    assert f"margin at most {100.0 * (1.0 - found.size.low):.0f} %;" in line
    assert "none" not in line


def test_tables_of_earlier_versions_end_at_four_times_the_value():
    required = Requirement("r", "APE", 0.1, 0.9, "mixed")
    shares = np.sum(np.full((100, 1), 0.02) <= 0.1 * counted_sizes(0.1)[:161], axis=0)
    assert judged(required, np.zeros(100), np.zeros(100), shares).size.value == pytest.approx(
        0.02, rel=0.05
    )


def test_limits_of_a_mixed_size_contain_the_size_of_equal_errors():
    """All errors just within the value: the sizes at which shares are known are 4 % apart."""
    found = mixed(np.full((1000, 1), 0.9999), 0.9)
    assert found.size.low < 0.9999 <= found.size.high
    assert found.margin.low <= 1e-4


def test_more_samples_in_a_run_do_not_narrow_the_interval():
    """Constant errors: each run has one value, however often it is sampled."""
    random = np.random.default_rng(2)
    once = np.abs(random.normal(size=(400, 1)))
    narrow, wide = (mixed(np.repeat(once, n, axis=1), 0.7) for n in (1, 500))
    assert narrow.size == wide.size
    assert narrow.share == wide.share


@pytest.mark.parametrize("interpretation", ["temporal", "ensemble", "mixed"])
def test_an_impossible_level_is_answered_with_none(interpretation):
    """99.9999 % from 100 runs, all of them far within the value."""
    level = (
        {"share": 0.999999, "level": 0.5} if interpretation == "temporal" else {"level": 1 - 1e-6}
    )
    required = Requirement("r", "APE", 1.0, interpretation=interpretation, **level)
    metric = np.full(100, 0.0 if interpretation == "mixed" else 0.01)
    found = judged(required, metric, np.zeros(100), np.full(161, 100.0))
    assert found.verdict == "not decided"
    assert "100 runs cannot show 99.9999 %: at least 3688878 are needed" in found.why
    assert np.isnan([found.size.value, found.size.high, found.margin.low]).all()
    # that it is missed can be seen
    metric = np.full(100, 0.5 if interpretation == "mixed" else 2.0)
    found = judged(required, metric, np.zeros(100), np.zeros(161))
    assert found.verdict == "fail"
    # an interval without a number is no reason
    assert np.isnan(found.size.low) == ("met in at most" in found.why)
    assert np.isnan(found.size.low) == (interpretation == "mixed")


def test_runs_that_did_not_end_count_against_the_requirement():
    status = np.repeat([0, 1], [90, 10])
    metric = np.where(status == 0, 0.1, np.nan)
    found = judged(Requirement("r", "APE", 1.0, 0.99, "ensemble"), metric, status)
    assert (found.verdict, found.runs, found.share.value) == ("fail", 100, 0.9)
    missed = mixed(np.full((100, 3), 0.1), 0.99, status=status)
    assert missed.verdict == "fail"
    assert "10 of 100 runs did not end and exceed every size" in missed.why


def test_runs_without_values_are_left_out_and_counted():
    metric = np.where(np.arange(100) < 40, np.nan, 0.1)
    required = Requirement("r", "PRE", 1.0, 0.9, "ensemble", window=1.0)
    found = judged(required, metric, np.zeros(100))
    assert (found.verdict, found.runs, found.without) == ("pass", 60, 40)
    none = judged(required, np.full(100, np.nan), np.zeros(100))
    assert (none.verdict, none.why) == ("not decided", "no run has values of PRE")
    assert np.isnan(none.size.value)


def test_a_boresight_opposite_to_its_target_is_half_a_turn_away():
    turn, axis = jnp.array([0.0, 1.0, 0.0, 0.0]), jnp.array([0.0, 0.0, 1.0])
    found = np.asarray(across_and_about(turn, axis))
    assert np.linalg.norm(found) == pytest.approx(np.pi)
    assert found @ axis == pytest.approx(0.0, abs=1e-15)


def test_runs_without_a_value_of_an_index_have_the_columns_of_all_others(scenario):
    """A block of such runs ended a search: its table did not fit to those of the others."""
    budget = PointingBudget(scenario, 2, scenario.count + 1, 2, moments=True)
    budget.finish()
    columns = budget.moments()
    expected = [name for each in scenario.requirements for name in moment_columns(each)]
    assert sorted(columns) == sorted(expected)
    assert {name.rpartition(".")[2] for name in expected} >= {"0", "2", "mean_square", "size"}
    for values in columns.values():
        assert np.all(np.isnan(values))
