"""Allan deviations and noise parameters of a gyro against theory, exact likelihood and records."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.fft import dct
from scipy.integrate import quad

import gyrostat as gs
from gyrostat.identification.gyro.allan_deviation import (
    allan_deviations,
    cluster_sizes,
    degrees_of_freedom,
)
from gyrostat.identification.gyro.fit import axis_noise
from gyrostat.identification.gyro.likelihood import transformed
from gyrostat.identification.gyro.noise import (
    NAMES,
    allan_variances,
    coefficient_variances,
    mean_rate_covariance,
)
from gyrostat.identification.gyro.simulate import simulated_rates

TRUTH = {"quantisation": 2.0, "angle_walk": 1.0, "bias_instability": 0.5, "bias_walk": 0.02}
VARIANCES = np.array([TRUTH[name] ** 2 for name in NAMES])


def covariance(variances, count):
    """Generalised covariance of mean rates over 1 s, (count, count)."""
    lag = np.abs(np.subtract.outer(np.arange(count), np.arange(count))).astype(float)
    each = [mean_rate_covariance(name, lag.ravel()).reshape(lag.shape) for name in NAMES]
    return np.tensordot(variances, each, 1)


def test_allan_deviation_is_that_of_allantools():
    allantools = pytest.importorskip("allantools", reason="allantools is not installed")
    rate = simulated_rates(TRUTH, 5000, 0.02, np.random.default_rng(1)) + 7.0
    sizes = cluster_sizes(rate.size)
    time, theirs, _, _ = allantools.oadev(rate, rate=50.0, data_type="freq", taus=0.02 * sizes)
    ours = allan_deviations(rate, sizes)
    assert np.array_equal(np.round(time / 0.02), sizes)
    np.testing.assert_allclose(ours, theirs, rtol=1e-10)


def test_allan_deviation_is_that_of_neighbouring_means():
    rate = np.random.default_rng(2).normal(size=400)
    for size in (1, 3, 50, 133):
        means = np.array([rate[k : k + size].mean() for k in range(400 - size + 1)])
        expected = np.sqrt(0.5 * np.mean((means[size:] - means[:-size]) ** 2))
        assert allan_deviations(rate, np.array([size]))[0] == pytest.approx(expected, rel=1e-12)


def test_allan_variances_are_those_of_the_standard():
    time = np.array([0.3, 1.0, 20.0])
    expected = [3.0 / time**2, 1.0 / time, np.full(3, 2.0 * np.log(2.0) / np.pi), time / 3.0]
    np.testing.assert_allclose(allan_variances(time), expected, rtol=1e-12)


def test_flicker_variance_is_the_integral_of_its_spectrum():
    def integrand(x):  # of 4 S(f) sin^4 / (pi f tau)^2, x = pi f tau
        return 4.0 / (2.0 * np.pi) * np.sin(x) ** 4 / x**3

    parts = [quad(integrand, k * np.pi, (k + 1) * np.pi)[0] for k in range(200)]
    assert allan_variances(np.ones(1))[2, 0] == pytest.approx(sum(parts), rel=1e-5)


def test_variances_of_the_cosine_transform_are_exact():
    count = 257
    for index, name in enumerate(NAMES):
        dense = covariance(np.eye(4)[index], count)
        exact = np.diag(dct(dct(dense, norm="ortho", axis=0), norm="ortho", axis=1))[1:]
        ours = coefficient_variances(count, 1.0)[index]
        np.testing.assert_allclose(ours, exact, rtol=2e-3 if "instability" in name else 1e-7)


def test_likelihood_ratio_is_that_of_the_dense_covariance():
    """For white noise and random walk, whose covariance the transform diagonalises exactly."""
    count = 120
    rate = simulated_rates(
        {"angle_walk": 1.0, "bias_walk": 0.2, "rate_ramp": 0.03},
        count,
        1.0,
        np.random.default_rng(3),
    )
    record = transformed(rate, 1.0)
    lines = np.column_stack([np.ones(count), np.arange(count)])
    free = np.linalg.svd(lines.T)[2][2:]  # orthonormal contrasts that annul lines

    def dense(variances):
        inner = free @ covariance(variances, count) @ free.T
        contrast = free @ rate
        return -0.5 * (np.linalg.slogdet(inner)[1] + contrast @ np.linalg.solve(inner, contrast))

    first, second = np.array([0.0, 0.9, 0.0, 0.03]), np.array([0.0, 3.0, 0.0, 0.3])
    exact = dense(first) - dense(second)
    ours = record.at(first)[0].likelihood - record.at(second)[0].likelihood
    assert ours == pytest.approx(exact, rel=1e-3)
    assert abs(exact) > 1.0
    # with all kinds, at parameters 10 % apart: correlations that are left out cost little
    exact = dense(VARIANCES) - dense(1.21 * VARIANCES)
    ours = record.at(VARIANCES)[0].likelihood - record.at(1.21 * VARIANCES)[0].likelihood
    assert ours == pytest.approx(exact, abs=0.5)


def test_maximum_is_higher_than_its_neighbours_and_limits_are_at_the_quantile():
    rate = simulated_rates(TRUTH, 4000, 1.0, np.random.default_rng(4))
    record = transformed(rate, 1.0)
    best = record.maximise()
    for index in range(4):
        for factor in (0.9, 1.1):
            trial = best.variances * np.where(np.arange(4) == index, factor, 1.0)
            assert record.at(trial)[0].likelihood <= best.likelihood + 1e-4
    freest = record.maximise(negative=True).likelihood
    assert freest >= best.likelihood
    for end in record.limits(1, best):
        profile = record.maximise(1, end, negative=True).likelihood
        assert 2.0 * (freest - profile) == pytest.approx(3.8415, abs=2e-2)


@pytest.mark.parametrize(("count", "size"), [(90, 1), (90, 4), (90, 20), (600, 64), (600, 150)])
@pytest.mark.parametrize("pulses", [1.0, 1e6])
def test_degrees_of_freedom_are_those_of_the_quadratic_form(count, size, pulses):
    """Also where quantisation rules, whose errors are independent from sample to sample."""
    variances = VARIANCES * np.array([pulses, 1.0, 1.0, 1.0])
    sums = np.tri(count + 1, count, -1)
    second = (sums[2 * size :] - 2.0 * sums[size:-size] + sums[: -2 * size]) / size
    inner = second @ covariance(variances, count) @ second.T
    exact = np.trace(inner) ** 2 / np.sum(inner**2)
    ours = degrees_of_freedom(variances, count, 1.0, np.array([size]))[0]
    assert ours == pytest.approx(exact, rel=1e-2)


def test_simulated_noise_has_the_allan_deviation_of_its_parameters():
    generator = np.random.default_rng(5)
    sizes = np.array([1, 10, 100])
    for index, name in enumerate(NAMES):
        variances = [
            allan_deviations(simulated_rates({name: 1.0}, 3000, 1.0, generator), sizes) ** 2
            for _ in range(100)
        ]
        expected = allan_variances(sizes.astype(float))[index]
        np.testing.assert_allclose(np.mean(variances, axis=0), expected, rtol=0.1)


def test_intervals_hold_the_truth_about_as_often_as_they_say():
    """The proof is in benchmarks/gyro_coverage.py; here of 5 x 30 intervals."""
    generator = np.random.default_rng(6)
    truth = {"quantisation": 3.0, "angle_walk": 1.0, "bias_walk": 0.01}
    held = 0
    for _ in range(30):
        noise = axis_noise("x", simulated_rates(truth, 1500, 1.0, generator), 1.0)
        held += sum(p.low <= truth.get(n, 0.0) <= p.high for n, p in noise.parameters.items())
    assert 0.9 <= held / 150 <= 0.995


def test_what_the_record_does_not_determine_is_said_with_a_limit():
    noise = axis_noise("x", np.random.default_rng(7).normal(size=2000), 1.0)
    assert noise.parameters["angle_walk"].value == pytest.approx(1.0, rel=0.1)
    for name in ("quantisation", "bias_instability", "bias_walk", "rate_ramp"):
        estimate = noise.parameters[name]
        assert not estimate.observable
        assert estimate.sigma is None
        assert "not observable, because" in estimate.text()
        assert estimate.high > 0.0
    assert noise.warnings == ()


def test_a_bandwidth_below_the_sampling_frequency_is_warned_of_and_left_out_by_shortest():
    white = np.random.default_rng(8).normal(size=20_004)
    slow = np.convolve(white, np.full(5, 0.2), "valid")
    noise = axis_noise("x", slow, 1.0)
    assert any("Hz, the noise power is" in text for text in noise.warnings)
    averaged = axis_noise("x", slow, 1.0, 50)
    assert averaged.warnings == ()
    assert averaged.parameters["angle_walk"].value == pytest.approx(1.0, rel=0.15)


def rates(count=1500):
    generator = np.random.default_rng(9)
    return np.array(
        [simulated_rates({"angle_walk": 1e-4}, count, 0.5, generator) for _ in range(2)]
    ).T


def written(path, header, columns):
    lines = [header, *(",".join(repr(float(v)) for v in row) for row in columns)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_rates_angles_and_increments_give_the_same(tmp_path):
    rate = rates()
    time = 0.5 * np.arange(1, rate.shape[0] + 1)
    angle = 0.5 * np.cumsum(rate, axis=0)
    first = gs.allan(rate, interval="500 ms")
    files = {
        "time_s,rate_x [deg/s],rate_y [deg/s]": np.column_stack([time, np.degrees(rate)]),
        "time_ms,increment_x [arcsec],increment_y [arcsec]": np.column_stack(
            [1e3 * time, 0.5 * 3600.0 * np.degrees(rate)]
        ),
        "time_s,angle_x [deg],angle_y [deg]": np.column_stack(
            [np.append(0.0, time), np.degrees(np.vstack([np.zeros(2), angle]))]
        ),
    }
    for number, (header, columns) in enumerate(files.items()):
        result = gs.allan(written(tmp_path / f"{number}.csv", header, columns))
        for axis in ("x", "y"):
            np.testing.assert_allclose(result[axis].deviation, first[axis].deviation, rtol=1e-6)
    named = written(tmp_path / "n.csv", "a,b", rate)
    result = gs.allan(
        named, columns="rate_x=a,rate_y=b", units="rate_x=rad/s,rate_y=rad/s", interval=0.5
    )
    np.testing.assert_allclose(result["y"].deviation, first["y"].deviation, rtol=1e-6)


BASE = [[0.1 * k, (-1.0) ** k] for k in range(12)]


@pytest.mark.parametrize(
    ("header", "change", "message"),
    [
        ("time_s,rate_x_deg/s", {5: [0.4, 1.0]}, "row 7, column 'time_s': found a time not after"),
        ("time_s,rate_x_deg/s", {5: None}, "row 7, column 'time_s': found 0.2 s since the sample"),
        ("time_s,rate_x_deg/s", {5: [0.5, "nan"]}, "row 7, column 'rate_x_deg/s': found "),
        (
            "time_s,rate_x_deg/s",
            {5: [0.5, ""]},
            "row 7, column 'rate_x_deg/s': found an empty cell",
        ),
        ("time_s,rate_x [kg]", {}, "found unit 'kg', expected a unit of speed"),
        ("time_s,rate_x", {}, "column 'rate_x': found no unit"),
        ("time_s,speed_rpm", {}, "found columns 'time_s', 'speed_rpm', expected one kind: rate_x"),
        ("time_s,rate_x_deg/s", {}, "found 12 samples of 0.1 s, expected at least 200"),
    ],
)
def test_bad_records_are_refused_with_one_line(tmp_path, header, change, message):
    rows = [change.get(k, row) for k, row in enumerate(BASE)]
    text = "\n".join([header, *(",".join(map(str, row)) for row in rows if row is not None)])
    path = tmp_path / "gyro.csv"
    path.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(gs.InputError) as raised:
        gs.allan(path)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def test_times_and_an_interval_are_not_both_taken(tmp_path):
    path = written(tmp_path / "gyro.csv", "t [s],rate_x [rad/s]", np.ones((9, 2)))
    with pytest.raises(gs.InputError, match=r"found an interval and the times in 't \[s\]'"):
        gs.allan(path, interval="1 s")


@pytest.mark.parametrize(
    ("record", "options", "message"),
    [
        ({}, {"interval": 1.0}, "record: found dict, expected a path, or an array of rates"),
        (np.ones((9, 4)), {"interval": 1.0}, r"found an array of shape \(9, 4\), expected"),
        (np.arange(9.0), {}, "interval: found none, expected the time between"),
        (np.arange(9.0), {"interval": 0.0}, "interval: found 0 s, expected a time above 0"),
        (np.ones(9), {"interval": 1.0}, "record: x: found one value throughout, expected noise"),
        ([1.0, np.inf], {"interval": 1.0}, r"record: x\[1\]: found inf, expected a number"),
        (np.arange(900.0), {"interval": 1.0, "shortest": 0.2}, "shortest: found 0.2 s"),
        (np.arange(900.0), {"interval": 1.0, "shortest": 9.0}, "found 100 samples of 9 s"),
    ],
)
def test_bad_arrays_are_refused(record, options, message):
    with pytest.raises(gs.InputError, match=message):
        gs.allan(record, **options)


def test_command_line_writes_json_picture_and_a_section_that_a_scenario_reads(tmp_path, run):
    record = written(
        tmp_path / "gyro.csv",
        "time_s,rate_x_rad/s,rate_y_rad/s",
        np.column_stack([0.5 * np.arange(1500), rates()]),
    )
    code, out, err = run("allan", record, "--out", tmp_path / "out", "--json")
    assert code == 0, err
    content = json.loads(out)
    walk = content["axes"]["x"]["parameters"]["angle_walk"]
    assert walk["low"] < 1e-4 < walk["high"]
    assert walk["unit"] == "rad/√s"
    assert (tmp_path / "out" / "allan.svg").read_text(encoding="utf-8").startswith("<svg")
    examples = Path(__file__).parents[2] / "examples" / "scenarios"
    scenario = (examples / "wheel_array.toml").read_text(encoding="utf-8")
    begin = scenario.index("[sensors]")
    end = scenario.index("\n[", begin)
    section = (tmp_path / "out" / "sensors.toml").read_text(encoding="utf-8")
    target = tmp_path / "scenario.toml"
    target.write_text(scenario[:begin] + section + scenario[end:], encoding="utf-8")
    for path in examples.iterdir():
        if path.name != "wheel_array.toml" and path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    read = gs.read_scenario(target)
    assert read.values["sensors.angle_walk"] == pytest.approx(
        max(content["axes"][a]["parameters"]["angle_walk"]["value"] for a in "xy"), rel=5e-3
    )
    code, _, err = run("allan", tmp_path / "none.csv", "--out", tmp_path / "out")
    assert code == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1


def test_picture_has_a_panel_for_each_axis():
    figure = gs.allan(rates(600), interval=0.5).plot()
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "Allan deviation, x (deg/h)",
        "Allan deviation, y (deg/h)",
    ]
