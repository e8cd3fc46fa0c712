"""Comparison of fits: one wheel over dates, the wheels of a batch."""

import json
import re
from dataclasses import replace
from datetime import datetime, timedelta
from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import kstest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.identification import compare_fits, stored_fit
from gyrostat.identification.judge.fit_changes import days
from gyrostat.identification.judge.spread import between, from_others, holm, line
from gyrostat.identification.result.stored_fit import StoredFit, Tolerance, parse_date
from gyrostat.reports.comparison import comparison_figure
from gyrostat.wheel.friction import ViscousCoulomb
from gyrostat.wheel.model_file import WheelModel, write_model

NAMES = ("motor_constant", "viscous", "coulomb")
UNITS = ("N·m/A", "N·m·s/rad", "N·m")
TRUTH = np.array([0.0228, 4.83e-6, 0.8795e-3])
SIGMA = np.array([2e-5, 2e-7, 4e-6])
CORRELATION = np.array([[1.0, 0.5, 0.3], [0.5, 1.0, -0.3], [0.3, -0.3, 1.0]])
OWN = CORRELATION * np.outer(SIGMA, SIGMA)
ONE_PERCENT = 0.01 * TRUTH
START = datetime(2026, 1, 1)


def made(values, day=None, *, tolerance=0.01, inertia=1.5e-3, serial="RW-1", temperature=None):
    """Fit of a wheel whose inertia was given with a tolerance."""
    errors = tolerance * TRUTH
    return StoredFit(
        name=f"{serial}-{day}",
        model="viscous-coulomb",
        names=NAMES,
        units=UNITS,
        values=np.asarray(values),
        covariance=OWN + np.outer(errors, errors),
        tolerances={"inertia": Tolerance(tolerance, errors)},
        inertia=inertia,
        serial=serial,
        date=None if day is None else START + timedelta(days=day),
        temperature=temperature,
    )


def drawn(random, count, shift=0.0):
    """Fits of one wheel: own errors for each, one common error of the inertia."""
    common = TRUTH + ONE_PERCENT * random.standard_normal()
    values = common + random.multivariate_normal(np.zeros(3), OWN, count)
    values[-1] += shift
    return [made(v, 30.0 * k) for k, v in enumerate(values)]


def compared(fits, same_wheel=True):
    labels = [str(k) for k in range(len(fits))]
    return compare_fits(fits, labels, same_wheel=same_wheel, same_bench=False)


def test_an_error_that_all_fits_share_cancels_in_their_differences():
    random = np.random.default_rng(910500)
    rows = [compared(drawn(random, 2)).changes[1] for _ in range(300)]
    deviates = [row.difference / row.sigma for row in rows]
    apart = compared(drawn(random, 2)).changes[1]
    assert kstest(deviates, "norm").pvalue > 0.001
    assert apart.sigma == pytest.approx(np.sqrt(2.0) * SIGMA[0])
    # other tolerances, or another inertia, are no common error
    mixed = compared([made(TRUTH, 0.0), made(TRUTH, 1.0, tolerance=0.02)])
    assert mixed.shared == ()
    assert mixed.changes[1].sigma > 4e-4
    assert any("only equal ones" in note for note in mixed.notes)
    other = compared([made(TRUTH, 0.0), made(TRUTH, 1.0, inertia=1.6e-3, temperature=20.0)])
    assert other.shared == ()
    assert any("given inertias differ" in note for note in other.notes)


def test_scales_are_common_where_the_bench_is():
    scale = {"current_scale": Tolerance(0.01, 0.01 * TRUTH)}
    first, second = (made(TRUTH, day) for day in (0.0, 1.0))
    both = [StoredFit(**{**vars(fit), "tolerances": scale}) for fit in (first, second)]
    apart = compare_fits(both, "ab", same_wheel=True, same_bench=False).changes[1].sigma
    common = compare_fits(both, "ab", same_wheel=True, same_bench=True)
    assert common.shared == ("current_scale",)
    assert common.changes[1].sigma == pytest.approx(np.sqrt(2.0) * SIGMA[0])
    assert apart > 10.0 * common.changes[1].sigma


def test_false_alarms_over_all_tests_are_five_percent_and_a_change_is_found():
    random = np.random.default_rng(910501)
    alarms = found = 0
    for _ in range(150):
        plain, changed = compared(drawn(random, 4)), compared(drawn(random, 4, 6.0 * SIGMA))
        rows = [*plain.changes, *plain.trends]
        assert plain.tests == len(rows) == 3 * 4 + 3
        alarms += any(row.significant for row in rows)
        last = [c for c in changed.changes if c.fit == "3"]
        found += any(c.significant for c in last)
    # at most 5 %: 7.5 of 150 with a standard deviation of 2.7
    assert alarms <= 16
    assert found >= 140


def test_a_joint_test_sees_a_change_across_the_correlation():
    """Coulomb and viscous rise together by 2.5 sigma each, against their correlation."""
    shift = np.array([0.0, 2.5, 2.5]) * np.sqrt(2.0) * SIGMA
    result = compared([made(TRUTH, 0.0), made(TRUTH + shift, 1.0)])
    together, *single = result.changes
    z = np.array([0.0, 2.5, 2.5])
    assert together.parameter == "all parameters"
    assert together.chance < min(row.chance for row in single)
    chi_square = z @ np.linalg.solve(CORRELATION, z)
    assert together.chance == pytest.approx(4.0 * _tail(chi_square, 3), rel=1e-6)


def _tail(value, freedom):
    from scipy.stats import chi2

    return float(chi2.sf(value, freedom))


def test_a_trend_has_its_slope_and_honest_sigma():
    random = np.random.default_rng(910502)
    time = np.array([0.0, 10.0, 25.0, 40.0, 80.0])
    deviates = []
    for _ in range(400):
        values = 1.0 + 0.03 * time + random.multivariate_normal(np.zeros(5), 0.01 * np.eye(5) + 1.0)
        found = line(time, values, 0.01 * np.eye(5) + 1.0)
        deviates.append((found.slope - 0.03) / np.sqrt(found.covariance[1, 1]))
    # the enlarged sigma of records that scatter makes the deviates slightly narrow
    assert 0.75 < np.std(deviates) < 1.05
    exact = line(time, 1.0 + 0.03 * time, 0.01 * np.eye(5))
    np.testing.assert_allclose([exact.start, exact.slope], [1.0, 0.03], rtol=1e-12)
    scattered = line(time, np.array([0.0, 9.0, -9.0, 9.0, 0.0]), 0.01 * np.eye(5))
    assert scattered.chance > 0.5
    # a common error moves the line, but is not enlarged by the scatter
    common = line(time, np.array([0.0, 9.0, -9.0, 9.0, 0.0]), 0.01 * np.eye(5) + 1.0)
    expected = scattered.covariance + np.diag([1.0, 0.0])
    np.testing.assert_allclose(common.covariance, expected, rtol=1e-6, atol=1e-9)


def test_the_spread_between_wheels_is_estimated_and_covered():
    random = np.random.default_rng(910503)
    covariance = np.diag([0.5, 1.0, 1.5, 1.0, 0.7, 1.2, 0.9, 1.0]) ** 2
    spreads, covered, alarms = [], 0, 0
    for _ in range(300):
        errors = random.multivariate_normal(np.zeros(8), covariance)
        found = between(3.0 + 2.0 * random.standard_normal(8) + errors, covariance)
        spreads.append(found.spread**2)
        covered += found.low <= 2.0 <= found.high
        alarms += between(3.0 + errors, covariance).chance < 0.05
    assert np.mean(spreads) == pytest.approx(4.0, rel=0.12)
    assert covered >= 273  # 95 % of 300 is 285, sigma 3.8
    assert alarms <= 26
    equal = between(np.ones(4), np.eye(4))
    assert (equal.spread, equal.low, equal.mean) == (0.0, 0.0, 1.0)


def test_a_wheel_unlike_the_others_is_found_in_their_spread():
    values = np.array([1.0, 1.1, 0.9, 1.05, 0.95, 3.0])
    covariance = 0.01**2 * np.eye(6)
    chances = [from_others(values, covariance, k)[2] for k in range(6)]
    assert chances[5] < 1e-3
    assert min(chances[:5]) > 0.5
    difference, _, _ = from_others(values, covariance, 5)
    assert difference == pytest.approx(2.0, abs=1e-3)
    result = compared(
        [made(TRUTH * v, serial=f"RW-{k}", tolerance=1e-4) for k, v in enumerate(values)], False
    )
    assert [c.fit for c in result.changes if c.significant] == ["5", "5", "5"]
    assert all(s.significant for s in result.spreads)


def test_the_correction_is_that_of_holm():
    np.testing.assert_allclose(holm([0.01, 0.04, 0.03, 0.005]), [0.03, 0.06, 0.06, 0.02])
    np.testing.assert_allclose(holm([0.9, 0.5]), [1.0, 1.0])


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("2026-03-01", datetime(2026, 3, 1)),
        ("2026-03-01T12:00:00+02:00", datetime(2026, 3, 1, 10)),
        ("1.3.2026", datetime(2026, 3, 1)),
        ("1 March 2026", datetime(2026, 3, 1)),
        ("03/01/2026", None),
        ("yesterday", None),
    ],
)
def test_dates(text, expected):
    assert parse_date(text) == expected


@pytest.fixture(scope="module")
def fit(record):
    from gyrostat.identification import identify

    return identify(record(), inertia=1.5e-3, speed_sigma=0.5236, tolerance={"inertia": 0.01})


@pytest.fixture
def files(fit, tmp_path):
    """Two fit.json files: dates, serial number, and a Coulomb torque that has risen."""
    paths = []
    for k, factor in enumerate((1.0, 1.2)):
        content = fit.to_dict()
        content["parameters"]["coulomb"]["value"] *= factor
        content["metadata"] = [{"serial": "RW-7", "date": f"2026-0{k + 1}-01"}]
        (tmp_path / str(k)).mkdir()
        path = tmp_path / str(k) / "fit.json"
        path.write_text(json.dumps(content), encoding="utf-8")
        paths.append(path)
    return paths


def test_a_fit_is_read_from_its_file_as_it_is(fit, tmp_path):
    path = tmp_path / "fit.json"
    path.write_text(json.dumps(fit.to_dict()), encoding="utf-8")
    stored, own = stored_fit(path), stored_fit(fit)
    assert stored.names == own.names == ("motor_constant", "viscous", "coulomb", "static")
    places = [fit.names.index(n) for n in own.names]
    np.testing.assert_allclose(stored.covariance, fit.covariance[np.ix_(places, places)], rtol=1e-9)
    assert stored.inertia == 1.5e-3
    errors = stored.tolerances["inertia"].errors
    np.testing.assert_allclose(errors, 0.01 * stored.values, rtol=2e-3)


def test_the_command_compares_files(run, files, tmp_path):
    out = tmp_path / "out"
    code, text, err = run("compare", *reversed(files), "--out", out, "--json")
    assert code == 0
    result = json.loads(text)
    assert result == json.loads((out / "comparison.json").read_text(encoding="utf-8"))
    assert [fit["label"] for fit in result["fits"]] == ["2026-01-01", "2026-02-01"]
    assert (result["same_wheel"], result["shared"]) == (True, ["inertia"])
    changed = {c["parameter"] for c in result["changes"] if c["significant"]}
    assert {"coulomb", "all parameters"} <= changed
    assert "static" not in changed
    assert "the error of the inertia is common" in err
    page = (out / "comparison.html").read_text(encoding="utf-8")
    labels = re.findall(r'<text class="x"[^>]*>([^<]+)</text>', page)
    assert labels
    assert all(re.fullmatch(r"202[56]-\d\d-\d\d( \d\d:\d\d)?", label) for label in labels)
    assert "coulomb (mN·m)</text>" in page
    assert not re.search(r"[ (>]N·m\b", page)  # charts and tables have the same units
    code, _, err = run("compare", *(p.parent for p in files), "--out", out, "--wheels", "different")
    assert code == 0
    assert "fits of different wheels" in err
    assert gs.compare(files, dates=["2026-05-01", "2026-04-01"]).labels[0] == "2026-04-01"


@pytest.mark.parametrize(
    ("change", "words", "found"),
    [
        (lambda c: c.pop("correlation"), (), "key 'correlation': found none"),
        (lambda c: c.update(parameters=[]), (), "its content: found none or another type"),
        (lambda c: c.update(converged=False), (), "did not converge"),
        (lambda c: c.update(impossible=["x"]), (), "not valid (x)"),
        (lambda c: c.update(metadata=[]), (), "found no serial number"),
        (lambda c: c.update(metadata=[{"serial": "a"}, {"serial": "b"}]), (), "several wheels"),
        (lambda c: c["parameters"]["coulomb"].update(sigma=0.0), (), "impossible covariance"),
        (lambda c: c["parameters"]["coulomb"].update(value=float("nan")), (), "impossible cov"),
        (lambda c: None, ("--dates", "2026-01-01"), "--dates: found 1, expected one for each"),
        (lambda c: None, ("--dates", "1/2/2026,x"), "expected a date such as"),
        (lambda c: None, ("--wheels", "equal"), "--wheels"),
    ],
)
def test_bad_input_is_one_line(run, files, tmp_path, change, words, found):
    content = json.loads(files[0].read_text(encoding="utf-8"))
    change(content)
    files[0].write_text(json.dumps(content), encoding="utf-8")
    code, out, err = run("compare", *files, *words, "--out", tmp_path / "out")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert found in err
    assert not (tmp_path / "out").exists()


def test_one_fit_or_none_in_common_is_refused():
    with pytest.raises(InputError, match="found 1 fit, expected at least 2"):
        compared([made(TRUTH, 0.0)])
    other = StoredFit(**{**vars(made(TRUTH)), "names": ("a", "b", "c")})
    with pytest.raises(InputError, match="no parameter that two fits have in common"):
        compared([made(TRUTH), other])


@pytest.mark.parametrize(("count", "label"), [(14, "RW-{:02d} of the second batch"), (3, "{}")])
def test_labels_of_a_batch_are_whole_and_apart(count, label):
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    labels = [label.format(k) for k in range(count)]
    fits = [made(TRUTH, serial=own) for own in labels]
    batch = compare_fits(fits, labels, same_wheel=False, same_bench=False)
    figure = comparison_figure(batch)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    drawn_texts = figure.axes[-1].get_xticklabels()
    assert [text.get_text() for text in drawn_texts] == labels
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in drawn_texts]
    for box in boxes:
        assert min(box.x0, box.y0) >= 0.0
        assert box.x1 <= figure.bbox.x1
    assert all(a.x1 < b.x0 for a, b in pairwise(boxes))


def test_dates_are_counted_in_days_from_the_first():
    np.testing.assert_allclose(
        days([made(TRUTH, day) for day in (2.5, 0.25, 1.0)]), [2.25, 0.0, 0.75]
    )
    assert days([made(TRUTH, 0.0), made(TRUTH)]) is None


def test_a_model_file_stands_for_its_fit(tmp_path):
    fit = made(TRUTH, 0, tolerance=0.0, temperature=21.0)
    model = WheelModel(
        ViscousCoulomb,
        {"inertia": 1.5e-3, **dict(zip(NAMES, TRUTH.tolist(), strict=True))},
        dict(zip(NAMES, SIGMA.tolist(), strict=True)),
        {"serial": "RW-1", "date": "2026-01-01", "temperature": "21 °C"},
        correlation=(NAMES, CORRELATION),
    )
    write_model(tmp_path / "model.toml", model)
    read = stored_fit(tmp_path / "model.toml")
    assert (read.names, read.units, read.serial) == (NAMES, UNITS, "RW-1")
    assert read.covariance == pytest.approx(OWN, rel=1e-12)
    assert (read.date, read.temperature, read.inertia) == (START, 21.0, 1.5e-3)
    later = made(TRUTH + 5.0 * SIGMA, 30.0, tolerance=0.0, temperature=21.0)
    by_file, by_fit = compared([read, later]), compared([fit, later])
    assert by_file.changes == by_fit.changes

    other = tmp_path / "flight"
    other.mkdir()
    write_model(other / "model.toml", replace(model, origin={}))
    result = gs.compare([other, tmp_path], wheels="same", dates="2027-01-01,2026-01-01")
    assert [change.difference for change in result.changes if change.parameter in NAMES] == [
        0.0
    ] * 3
    # what the flight does not show is not compared, and a temperature in words is none
    origin = {"known_beforehand": "inertia, viscous", "temperature": "warm"}
    write_model(other / "model.toml", replace(model, origin=origin))
    read = stored_fit(other / "model.toml")
    assert (read.names, read.temperature) == (("motor_constant", "coulomb"), None)
    assert read.covariance == pytest.approx(OWN[np.ix_([0, 2], [0, 2])], rel=1e-12)
    write_model(other / "model.toml", replace(model, sigma={}, correlation=None))
    with pytest.raises(InputError, match="no identified parameters"):
        stored_fit(other / "model.toml")
