"""Carrara and Kuga against closed forms, the printed numbers and a whole quick run."""

import json
import math

import numpy as np
import pytest
from scipy.optimize import least_squares
from typer.testing import CliRunner

from gyrostat import cli
from gyrostat.papers.carrara_kuga.printed import DETERMINISTIC, STATISTICAL, Column
from gyrostat.papers.carrara_kuga.single_start import (
    START_WITHOUT_STRIBECK,
    plain_iteration_succeeds,
)
from gyrostat.papers.carrara_kuga.single_wheel import breakaway_current, single_wheel, stop_time
from gyrostat.papers.carrara_kuga.table_of_parameters import table_of_parameters
from gyrostat.papers.carrara_kuga.virtual_bench import (
    estimate,
    modelled_speed,
    profile1,
    profile2,
    run_trial,
)

RPM = math.pi / 30.0
NAMES = ("motor_constant", "viscous", "coulomb", "static")
ISSUE_IDS = {
    "table1.motor_constant_det",
    "table1.viscous_det",
    "table1.coulomb_det",
    "table1.motor_constant",
    "table1.viscous",
    "table1.coulomb",
    "table1.static",
    "recovery.motor_constant_std",
    "recovery.viscous_std",
    "recovery.coulomb_std",
    "recovery.static_std",
    "recovery.efficiency_min",
    "recovery.efficiency_max",
    "convergence.fraction",
    "convergence.iterations_max",
    "rms.profile2_rpm",
    "rms.profile1_rpm",
    "rms.deterministic_profile2_rpm",
    "breakaway.current_A",
    "coast.stop_time_s",
    "coulomb_over_km_A",
    "table.pid_peak_deg",
    "table.pid_error_60s_deg",
    "table.pid_error_final_deg",
    "table.pid_start_transient_deg",
    "table.dmc_peak_exact_deg",
    "table.dmc_peak_coulomb_minus5_deg",
    "table.dmc_peak_coulomb_plus5_deg",
    "table.dmc_peak_coulomb_plus10_deg",
    "table.dmc_start_transient_deg",
    "table.dmc_peak_noise5rpm_deg",
    "table.dmc_peak_delay1s_deg",
    "table.speed_mode_peak_deg",
    "table.peak_ratio_coulomb5",
    "table.stick_time_s",
    "limit_cycle.overcompensated10_deg",
}
GOAL_IDS = {
    f"{controller}.{quantity}"
    for controller in ("compensator", "pid", "dmc_raw", "dmc_filtered", "speed_mode")
    for quantity in (
        "peak95_white_deg",
        "peak_max_white_deg",
        "peak95_hall_deg",
        "peak_max_hall_deg",
        "peak95_step30_deg",
        "peak95_lugre_deg",
        "true_peak95_white_deg",
        "true_peak95_hall_deg",
        "chatter95_A",
        "sign_changes95_per_s",
        "hunt_deg",
    )
}
OWN_IDS = {
    "limit_cycle.coulomb_only10_deg",
    "table1.motor_constant_drop_percent",
    "coulomb_over_km_det_A",
    "stribeck.jump_at_zero_speed",
    "inertia.not_separable",
    "recovery.pooled_efficiency_min",
    "recovery.pooled_efficiency_max",
    "convergence.plain_start_fraction",
    "convergence.plain_coulomb_start_fraction",
    "static.significance_sigma",
    "coulomb.unchanged_between_methods",
    "coulomb.chance_of_four_digits",
    "stribeck_speed.not_observable",
    "stribeck_speed.relative_sigma",
    "stribeck_speed.barely_affects_motor_viscous_coulomb",
    "stribeck_speed.barely_affects_static",
    "rms.deterministic_profile1_rpm",
    "crossings.profile2",
    "crossings.profile1",
    "crossings.profile1_twelve_cycles",
    "methods.difference_profile1_rpm",
    "methods.difference_profile2_rpm",
    "methods.statistical_closer_to_profile2",
    "methods.statistical_better_at_low_speed",
    "residuals.larger_near_crossings",
    "residuals.near_crossing_ratio",
}


def by_id(claims):
    return {claim.id: claim for claim in claims}


# As the paper prints Table 1: number, and one unit of its last digit.
PRINTED = {
    "table1.motor_constant_det": (0.0270, 1e-4),
    "table1.viscous_det": (5.16e-6, 1e-8),
    "table1.coulomb_det": (0.8795e-3, 1e-7),
    "table1.motor_constant": (0.0228, 1e-4),
    "table1.viscous": (4.83e-6, 1e-8),
    "table1.coulomb": (0.8795e-3, 1e-7),
    "table1.static": (0.9055e-3, 1e-7),
}


@pytest.mark.parametrize("name", PRINTED)
def test_table_1_is_rebuilt_to_its_rounding(name):
    claim = by_id(table_of_parameters().claims)[name]
    number, digit = PRINTED[name]
    assert claim.paper == number
    assert claim.ours == pytest.approx(number, abs=0.51 * digit)
    assert claim.tolerance == pytest.approx(0.5 * digit, rel=1e-6)
    assert claim.verdict == "reproduced"


def test_fifteen_per_cent_is_really_sixteen():
    claim = by_id(table_of_parameters().claims)["table1.motor_constant_drop_percent"]
    assert claim.ours == pytest.approx(100.0 * 42.0 / 270.0)
    assert claim.verdict == "not-reproduced"


def test_the_observable_current_moved():
    claims = by_id(table_of_parameters().claims)
    assert claims["coulomb_over_km_A"].ours == pytest.approx(38.6e-3, abs=0.05e-3)
    assert claims["coulomb_over_km_det_A"].ours == pytest.approx(32.6e-3, abs=0.05e-3)


def test_a_coasting_wheel_stops_at_its_analytic_time():
    rate, level, start = 0.00322, 0.5863, 100.0 * RPM
    claim = by_id(single_wheel().claims)["coast.stop_time_s"]
    assert claim.ours == pytest.approx(math.log(1.0 + rate * start / level) / rate, abs=1e-5)
    assert claim.ours == pytest.approx(17.36638086, abs=1e-5)


@pytest.mark.parametrize("column", [STATISTICAL, DETERMINISTIC])
def test_a_wheel_breaks_away_at_its_static_torque(column):
    found = breakaway_current(column.wheel())
    assert found == pytest.approx(column.static / column.motor_constant, rel=1e-12)


def test_a_faster_wheel_coasts_longer():
    wheel = DETERMINISTIC.wheel()
    times = [stop_time(wheel, speed) for speed in (10.0, 20.0, 40.0)]
    assert times == sorted(times)


def test_the_friction_curve_jumps_by_twice_the_static_torque():
    claim = by_id(single_wheel().claims)["stribeck.jump_at_zero_speed"]
    assert claim.ours == pytest.approx(2.0 * 0.9055e-3)
    assert claim.verdict == "not-reproduced"


def test_profile_2_is_ten_steps_of_alternating_sign():
    record = profile2(3)
    steps = record.current[:-1].reshape(10, 300)
    assert np.array_equal(record.time, np.arange(3001) / 10.0)
    assert np.all(steps == steps[:, :1])
    assert record.current[-1] == record.current[-2]
    assert np.all(np.abs(steps) >= 0.06)
    assert np.all(np.abs(steps) <= 0.15)
    assert np.array_equal(np.sign(steps[:, 0]), [1.0, -1.0] * 5)
    assert len(np.unique(np.abs(steps))) == 10


def test_profile_1_is_twelve_and_a_half_cycles():
    record = profile1(3)
    current = record.current[1:-1]
    turns = np.sum(np.sign(current[1:]) != np.sign(current[:-1]))
    peaks = [
        np.abs(half).max() for half in np.split(current, 1 + np.flatnonzero(np.diff(current > 0)))
    ]
    assert turns == 24
    assert len(peaks) == 25
    assert 0.079 <= min(peaks) <= max(peaks) <= 0.20
    assert record.current[0] == 0.0
    assert record.current[-1] == pytest.approx(0.0, abs=1e-6)


def test_records_are_those_of_their_seed():
    assert np.array_equal(profile2(5).speed, profile2(5).speed)
    assert not np.array_equal(profile2(5).current, profile2(6).current)
    noise = [run_trial(5).profile1, run_trial(5).profile2]
    first, second = (p.record.speed - p.true for p in noise)
    assert np.std(first) == pytest.approx(5.0 * RPM, rel=0.05)
    assert np.std(second) == pytest.approx(5.0 * RPM, rel=0.05)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.1


def test_the_estimate_is_that_of_another_solver():
    record, fit = profile2(1), estimate(profile2(1))
    mean = np.array([18.0, 0.00344, 0.5863, 0.0])
    sigma = np.array([5.0, 0.002, 0.3, 0.6])

    def stacked(x):
        wheel = Column(*(1.5e-3 * x)).wheel()
        speed = modelled_speed(wheel, record.time, record.current, 0.0)
        return np.concatenate([(x - mean) / sigma, (record.speed - speed) / (5.0 * RPM)])

    truth = np.array([0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3]) / 1.5e-3
    other = least_squares(stacked, truth, x_scale=truth, xtol=1e-12, ftol=1e-12, jac="3-point")
    deviation = 1.5e-3 * np.sqrt(np.diag(np.linalg.inv(other.jac.T @ other.jac)))
    assert fit.names == NAMES
    assert np.all(np.abs(fit.values - 1.5e-3 * other.x) < 0.02 * deviation)
    assert fit.sigma == pytest.approx(deviation, rel=0.01)
    assert fit.held == pytest.approx(
        {
            "inertia": 1.5e-3,
            "stribeck_speed": 4.0 * RPM,
            "current_bias": 0.0,
            "initial_speed": 0.0,
        }
    )


def test_an_unknown_paper_is_wrong_usage(tmp_path, monkeypatch, capsys):
    folder = tmp_path / "out"
    monkeypatch.setattr("sys.argv", ["gyrostat", "reproduce", "nobody", "--out", str(folder)])
    with pytest.raises(SystemExit) as ended:
        cli.main()
    assert ended.value.code == 2
    assert "expected one of carrara-kuga" in capsys.readouterr().err
    assert not folder.exists()


def test_one_start_is_a_gamble():
    # Seed 3 goes well from (15); on seed 2 the modelled wheel sticks, from T_s = c it does not.
    start = (18.0, 0.00344, 0.5863, 0.0)
    assert plain_iteration_succeeds(profile2(3), start)
    assert not plain_iteration_succeeds(profile2(2), start)
    assert plain_iteration_succeeds(profile2(2), START_WITHOUT_STRIBECK)


@pytest.fixture(scope="module")
def quick(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduce")
    arguments = ["reproduce", "carrara-kuga", "--quick", "--json", "--out", str(folder)]
    result = CliRunner().invoke(cli.app, arguments)
    assert result.exit_code == 0, result.output
    return folder, result


@pytest.mark.slow
def test_a_quick_run_gives_every_id(quick):
    folder, result = quick
    text = (folder / "claims.json").read_text(encoding="utf-8")
    content = json.loads(text)
    assert json.loads(result.stdout) == content
    assert list(content) == ["paper", "claims"]
    assert content["paper"] == "carrara-kuga"
    ids = [row["id"] for row in content["claims"]]
    assert len(ids) == len(set(ids))
    assert set(ids) == ISSUE_IDS | OWN_IDS | GOAL_IDS
    not_computed = {row["id"] for row in content["claims"] if "Not computed" in row["why"]}
    assert not_computed == GOAL_IDS
    for row in content["claims"]:
        assert list(row) == [
            "id",
            "quantity",
            "paper",
            "ours",
            "unit",
            "tolerance",
            "verdict",
            "why",
        ]
        assert row["quantity"]
        assert row["why"].endswith(".")
        assert (row["ours"] is None) == (row["verdict"] == "not-testable")
        assert (row["tolerance"] is None) == (row["paper"] is None)


@pytest.mark.slow
def test_a_quick_run_gives_the_known_numbers(quick):
    rows = json.loads((quick[0] / "claims.json").read_text(encoding="utf-8"))["claims"]
    ours = {row["id"]: row["ours"] for row in rows}
    verdict = {row["id"]: row["verdict"] for row in rows}
    # formal sigmas of this experiment; twelve records scatter by 20 % and more
    for name, sigma in zip(NAMES, (2.0e-5, 1.9e-7, 3.8e-6, 6.5e-5), strict=True):
        assert 0.5 * sigma < ours[f"recovery.{name}_std"] < 2.0 * sigma
    assert 0.4 < ours["recovery.efficiency_min"] <= ours["recovery.efficiency_max"] < 1.7
    pooled = ours["recovery.pooled_efficiency_min"], ours["recovery.pooled_efficiency_max"]
    assert 0.4 < pooled[0] <= pooled[1] < 2.0
    assert ours["convergence.fraction"] == 1.0
    assert ours["convergence.plain_start_fraction"] < 0.9
    assert ours["rms.profile2_rpm"] == pytest.approx(5.0, abs=0.1)
    assert ours["rms.profile1_rpm"] == pytest.approx(5.0, abs=0.1)
    assert 25.0 < ours["rms.deterministic_profile2_rpm"] < 60.0
    assert ours["breakaway.current_A"] == pytest.approx(0.9055e-3 / 0.0228, rel=1e-9)
    assert ours["coast.stop_time_s"] == pytest.approx(17.36638086, abs=1e-5)
    assert ours["static.significance_sigma"] == pytest.approx(0.4, abs=0.1)
    assert ours["crossings.profile1_twelve_cycles"] == 23.0
    assert [verdict[f"crossings.profile{k}"] for k in (1, 2)] == ["reproduced"] * 2
    assert [k for k, v in verdict.items() if v == "not-reproduced"] == [
        "table1.motor_constant_drop_percent",
        "stribeck.jump_at_zero_speed",
        "stribeck_speed.barely_affects_static",
        "table.pid_error_final_deg",
        "table.dmc_peak_exact_deg",
        "table.dmc_start_transient_deg",
        "table.peak_ratio_coulomb5",
    ]


@pytest.mark.slow
def test_a_quick_run_crosses_zero_as_computed_elsewhere(quick):
    rows = json.loads((quick[0] / "claims.json").read_text(encoding="utf-8"))["claims"]
    ours = {row["id"]: row["ours"] for row in rows}
    # from an independent simulation of the same settings, to its rounding
    assert ours["table.pid_peak_deg"] == pytest.approx(1.5, abs=0.01)
    assert ours["table.pid_start_transient_deg"] == pytest.approx(0.63, abs=0.005)
    assert ours["table.dmc_start_transient_deg"] == pytest.approx(0.39, abs=0.005)
    for name, error in (("minus5", 5.0), ("plus5", 5.0), ("plus10", 10.0)):
        peak = ours[f"table.dmc_peak_coulomb_{name}_deg"]
        assert peak == pytest.approx(0.0147 * error, rel=0.02)
    assert ours["table.dmc_peak_exact_deg"] < 0.002
    # while the wheel sticks only the integral and the attitude raise the torque, to 2 T_s or so
    assert 3.0 < ours["table.stick_time_s"] < 4.0
    assert ours["table.pid_peak_deg"] / ours["table.dmc_peak_noise5rpm_deg"] < 10.0
    assert ours["limit_cycle.overcompensated10_deg"] > 0.02
    assert ours["limit_cycle.coulomb_only10_deg"] < 0.02


@pytest.mark.slow
def test_a_quick_run_reports_and_shows_progress(quick):
    folder, result = quick
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert all(name in page for name in ISSUE_IDS | OWN_IDS | GOAL_IDS)
    assert page.count("<svg") == 11
    assert "Quick" in page
    written = [".gyrostat.json", "claims.json", "report.html"]
    assert sorted(path.name for path in folder.iterdir()) == written
    assert "12 of 12 records" in result.stderr
    assert "not-reproduced" in result.stderr
