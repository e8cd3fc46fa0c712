"""Carrara and Kuga against closed forms, the printed numbers and a whole quick run."""

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from gyrostat import cli
from gyrostat.core.jax64 import jax, jnp
from gyrostat.identification.read.statistics import crossing_times
from gyrostat.papers.carrara_kuga import CARRARA_KUGA
from gyrostat.papers.carrara_kuga.bench import (
    breakaway_current,
    estimate,
    modelled_speed,
    profile1,
    profile2,
    rms,
    run_trial,
    stop_time,
    trials,
)
from gyrostat.papers.carrara_kuga.dispersed import CANDIDATES, CLAIMED, claimed, crossing_figure
from gyrostat.papers.carrara_kuga.identification import table1
from gyrostat.papers.carrara_kuga.setup import (
    DETERMINISTIC,
    SINE_CURRENTS,
    STATISTICAL,
    Column,
    scaled,
)
from gyrostat.papers.carrara_kuga.table import limit_cycle
from gyrostat.papers.reproduction import Run
from gyrostat.simulation import Telemetry, bench_record
from gyrostat.wheel import speed_response
from gyrostat.wheel.friction.base import trial_values

RPM = math.pi / 30.0
NAMES = ("motor_constant", "viscous", "coulomb", "static")
PAPER = "carrara-kuga"
START = np.array([18.0, 0.00344, 0.5863, 0.0])
PRIOR = np.array([5.0, 0.002, 0.3, 0.6])


@pytest.fixture(scope="module")
def implied():
    """Claims on Table 1 and the model of the wheel."""
    values = table1(Run(True, lambda text: None))
    return {
        row.id: row.claim(values.values[row.id], values.facts)
        for row in CARRARA_KUGA.rows
        if row.id in values.values
    }


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
def test_table_1_is_rebuilt_to_its_rounding(name, implied):
    claim = implied[name]
    number, digit = PRINTED[name]
    assert claim.paper == number
    assert claim.ours == pytest.approx(number, abs=0.51 * digit)
    assert claim.tolerance == pytest.approx(0.5 * digit, rel=1e-6)
    assert claim.verdict == "reproduced"


def test_fifteen_per_cent_is_really_sixteen(implied):
    claim = implied["table1.motor_constant_drop_percent"]
    assert claim.ours == pytest.approx(100.0 * 42.0 / 270.0)
    assert claim.verdict == "not-reproduced"


def test_the_observable_current_moved(implied):
    claim = implied["coulomb_over_km_A"]
    assert claim.ours == pytest.approx(38.6e-3, abs=0.05e-3)
    assert "0.03257 A" in claim.why


def test_a_coasting_wheel_stops_at_its_analytic_time(implied):
    rate, level, start = 0.00322, 0.5863, 100.0 * RPM
    claim = implied["coast.stop_time_s"]
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


def test_the_friction_curve_jumps_by_twice_the_static_torque(implied):
    claim = implied["stribeck.jump_at_zero_speed"]
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
    trial = run_trial(5)
    first, second = (p.record.speed - p.true for p in (trial.profile1, trial.profile2))
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


@jax.jit
@jax.jacfwd
def slopes(x, time, current):
    return speed_response(Column(*(1.5e-3 * x)).wheel(), time, current, 0.0)[0]


def plain_iteration_succeeds(record, start):
    """Whether undamped Gauss-Newton, eqs. (10)-(14), ends with a residual at the noise level.

    The derivatives pass through the zero crossings with the jump that eq. (5) leaves out, so a
    failure is not that omission's.
    """
    x = np.array(start)
    for _ in range(30):
        with trial_values():  # also on the way to negative parameters
            wheel = Column(*(1.5e-3 * x)).wheel()
        residual = record.speed - modelled_speed(wheel, record.time, record.current, 0.0)
        slope = slopes(jnp.asarray(x), record.time, record.current)
        rows = np.vstack([np.diag(1.0 / PRIOR), np.asarray(slope) / (5.0 * RPM)])
        right = np.concatenate([(START - x) / PRIOR, residual / (5.0 * RPM)])
        if not np.isfinite(rows).all() or not np.isfinite(right).all():
            return False
        orthogonal, triangle = np.linalg.qr(rows)
        projected = orthogonal.T @ right
        if np.linalg.norm(projected) < 1e-3:
            return rms(residual) < 1.2 * 5.0 * RPM
        x = x + np.linalg.solve(triangle, projected)
    return False


def test_one_start_is_a_gamble():
    # Seed 3 goes well from (15); on seed 2 the modelled wheel sticks, from T_s = c it does not.
    assert plain_iteration_succeeds(profile2(3), START)
    assert not plain_iteration_succeeds(profile2(2), START)
    assert plain_iteration_succeeds(profile2(2), (*START[:3], START[2]))
    assert run_trial(2).recovered


def test_twelve_whole_cycles_cross_zero_an_odd_number_of_times():
    record = bench_record(
        STATISTICAL.wheel(),
        "sines",
        duration=300.0,
        telemetry=Telemetry(rate=10.0, speed_sigma=5.0 * RPM),
        amplitudes=SINE_CURRENTS,
        period=25.0,
        seed=1_000_000,
    )
    speed = modelled_speed(STATISTICAL.wheel(), record.time, record.current, 0.0)
    assert len(crossing_times(record.time, speed, noise=0.0)) == 23


@pytest.mark.slow
def test_coulomb_alone_too_large_gives_no_limit_cycle():
    assert limit_cycle(scaled(1.1)) < 0.02


def test_dispersed_runs_are_claimed_for_the_compensator_beside_the_others():
    numbers = {
        one.key: dict.fromkeys((*CLAIMED, "true_peak95_white_deg", "incomplete"), 0.01 * (k + 1))
        for k, one in enumerate(CANDIDATES)
    }
    part = claimed(numbers)
    rows = {row.id: row for row in CARRARA_KUGA.rows if row.full}
    assert set(part.values) == set(rows)
    peak = rows["compensator.peak95_white_deg"].claim(0.01, part.facts)
    assert "PID 0.02" in peak.why
    assert "at most 0.04 deg; met" in peak.why
    slow = rows["compensator.hunt_deg"].claim(0.03, part.facts)
    assert "at most 0.02 deg; not met" in slow.why


@pytest.mark.slow
def test_the_figure_of_one_crossing_has_a_line_for_each_controller():
    whole, close, current = crossing_figure().axes
    assert [len(axes.lines) for axes in (whole, close, current)] == [4, 4, 2]


@pytest.mark.slow
def test_a_quick_run_judges_every_claim_as_published(judged_as_published):
    judged_as_published(PAPER)


@pytest.mark.slow
def test_a_quick_run_gives_the_known_numbers(quick):
    run = quick(PAPER)
    ours = run.ours
    # formal sigmas of this experiment; twelve records scatter by 20 % and more
    for name, sigma in zip(NAMES, (2.0e-5, 1.9e-7, 3.8e-6, 6.5e-5), strict=True):
        assert 0.5 * sigma < ours[f"recovery.{name}_std"] < 2.0 * sigma
    assert 0.4 < ours["recovery.efficiency_min"] < 1.7
    assert ours["convergence.fraction"] == 1.0
    assert ours["rms.profile2_rpm"] == pytest.approx(5.0, abs=0.1)
    assert ours["rms.profile1_rpm"] == pytest.approx(5.0, abs=0.1)
    assert 25.0 < ours["rms.deterministic_profile2_rpm"] < 60.0
    assert ours["breakaway.current_A"] == pytest.approx(0.9055e-3 / 0.0228, rel=1e-9)
    assert ours["coast.stop_time_s"] == pytest.approx(17.36638086, abs=1e-5)
    assert "12 of 12 records" in run.stderr


@pytest.mark.slow
def test_a_quick_run_crosses_zero_as_computed_elsewhere(quick):
    ours = quick(PAPER).ours
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
    assert quick(PAPER).page.count('<div class="charts') == 9


@pytest.mark.slow
def test_one_record_does_not_tell_static_from_coulomb_friction(quick):
    weights = np.array([0.0, 0.0, -1.0, 1.0])
    found = quick(PAPER).run.once(trials)[:3]
    sigmas = [np.sqrt(weights @ trial.covariance @ weights) for trial in found]
    assert 0.026e-3 / np.mean(sigmas) == pytest.approx(0.4, abs=0.1)
