"""Runs of the small campaign: the same bits however they are flown, metrics as their histories."""

from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

from gyrostat.campaigns import run_campaign, worst_runs
from gyrostat.campaigns.execute import chosen_engine
from gyrostat.campaigns.pointing.collected import counted_sizes, instants
from gyrostat.core.errors import InputError
from gyrostat.runs.metrics.observer import ended
from gyrostat.simulation import Status

pytestmark = pytest.mark.optimised_c  # numbers of both engines


@pytest.fixture(scope="module")
def table(small):
    """Name -> (runs,) of every run; (runs, numbers) of lists, NaN where a run has none."""
    found = pq.read_table(small.store.table)
    columns = {name: found[name].to_numpy() for name in found.column_names}
    for name, values in columns.items():
        if values.dtype == object:
            size = max(len(row) for row in values if row is not None)
            none = np.full(size, np.nan)
            columns[name] = np.array([none if row is None else row for row in values])
    return columns


@pytest.fixture(scope="module")
def kept(small):
    """History of run 5."""
    with xr.open_dataset(small.store.history(5), engine="h5netcdf") as found:
        return found.load()


def same(columns, table, runs):
    for name, values in columns.items():
        np.testing.assert_array_equal(values, table[name][list(runs)], err_msg=name)


def test_a_run_has_the_same_bits_in_any_company(small, table):
    runs = (0, 3, 5, 63, 64, 77)
    same(small.fly(*runs, keep=(3,)).columns, table, runs)


def test_both_engines_agree(small, table):
    if small.engine == "jax":
        pytest.skip("needs a C compiler")
    runs = [*range(8), 77]
    for name, values in small.fly(*runs, engine="jax").columns.items():
        tolerance = 1e-6 if values.dtype == np.float32 else 1e-11
        np.testing.assert_allclose(
            values, table[name][runs], rtol=tolerance, atol=1e-14, err_msg=name
        )


def test_without_a_compiler_jax_flies_and_it_is_said_once(scenario, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    said = []
    assert chosen_engine("auto", scenario, "cpu", said.append) == "jax"
    assert chosen_engine("auto", scenario, "gpu", said.append) == "jax"
    assert len(said) == 1
    assert "C compiler: found none" in said[0]
    with pytest.raises(InputError, match="C compiler: found none"):
        chosen_engine("native", scenario, "cpu")
    with pytest.raises(InputError, match="expected cpu: it is compiled C"):
        chosen_engine("native", scenario, "gpu")


def test_another_engine_than_the_recorded_one_is_refused(small, scenario):
    other = "jax" if small.engine == "native" else "native"
    with pytest.raises(InputError, match=f"found {other}, expected {small.engine}"):
        run_campaign(scenario, small.out, runs=small.runs, seed=small.seed, engine=other)


def test_the_size_of_blocks_changes_no_byte(small, scenario, tmp_path):
    run_campaign(
        scenario,
        tmp_path,
        runs=small.runs,
        seed=small.seed,
        opener=small.opener,
        block=80,
        worst=0,
    )
    assert (tmp_path / "runs.parquet").read_bytes() == small.store.table.read_bytes()


def test_wheels_out_of_balance_shake_the_body_by_their_drawn_imbalance(table, kept):
    """Body inertia 0.06, 0.12, 0.14; the jitter that Newton and Euler give it, by hand."""
    row = {name: values[5] for name, values in table.items()}
    assert row["wheel.a.static_imbalance"] != row["wheel.b.static_imbalance"]
    axes = np.array([[1, -1, -1, 1], [1, 1, -1, -1], [1, 1, 1, 1]]) / np.sqrt(3.0)
    place = 0.05 * np.sqrt(3.0) * axes
    place[2, 1] = row["wheel.b.position.z"]
    static = np.array([row[f"wheel.{w}.static_imbalance"] for w in "abcd"])
    angle = kept.wheel_angle.values
    # angles count from where the axis is crossed by x
    first = np.cross([1.0, 0.0, 0.0], axes.T)
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(axes.T, first)
    cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
    radial, tangent = cosine * first + sine * second, cosine * second - sine * first
    dynamic = np.array([1e-9, 2e-9, 1e-9, 1e-9])[:, None]
    turn = dynamic * tangent - np.cross(place.T, static[:, None] * radial)
    expected = turn.sum(axis=1) / [0.06, 0.12, 0.14]
    np.testing.assert_allclose(kept.jitter.values, expected, atol=1e-6 * np.max(expected))
    # the angle is the integral of the speed
    np.testing.assert_allclose(
        np.diff(angle, axis=0),
        0.125 * (kept.wheel_speed.values[1:] + kept.wheel_speed.values[:-1]),
        atol=1e-9,
    )


def test_currents_follow_what_is_commanded_through_the_driver(table, kept):
    row = {name: values[5] for name, values in table.items()}
    constant = np.array([5e-3, row["wheel.b.motor_constant"], 5e-3, 5e-3])
    wanted = kept.torque.values[:-1] / constant
    limit = np.array([0.01, 0.15, 0.15, 0.15])
    target = np.clip(1e-4 * np.round(wanted / 1e-4), -limit, limit)
    current = kept.motor_current.values
    expected = target + (current[:-1] - target) * np.exp(-0.25 / 0.04)
    np.testing.assert_allclose(current[1:], expected, atol=1e-12)
    cut = np.abs(wanted) > limit
    assert np.any(cut)
    np.testing.assert_array_equal(kept.saturated.values[:-1], cut)


def test_a_bearing_that_wears_takes_its_new_friction_from_its_time_on(table, kept, scenario):
    """What the motor gives, less the change of the rotor's momentum, is the friction of wheel b."""
    row = {name: values[5] for name, values in table.items()}
    axis = scenario.axes[1]
    # the jitter turns the body about; the rate without it is what the rotor feels
    speed = kept.wheel_speed.values[:, 1]
    own = 2e-5 * (speed + kept.rate.values @ axis)
    constant, tau = row["wheel.b.motor_constant"], 0.04
    wanted = kept.torque.values[:-1, 1] / constant
    target = 1e-4 * np.round(wanted / 1e-4)
    start = kept.motor_current.values[:-1, 1]
    mean = target + (start - target) * tau / 0.25 * -np.expm1(-0.25 / tau)
    friction = constant * mean - np.diff(own) / 0.25
    middle = 0.5 * (speed[1:] + speed[:-1])
    fast = middle < -10.0  # where the Stribeck peak is over
    assert np.sum(fast & (kept.time.values[:-1] > 12.1)) > 4
    before = -row["wheel.b.coulomb"] + 1e-7 * middle
    after = -row["event.worn.coulomb"] + 3e-7 * middle
    # from 12.1 s on, within the control period that begins at 12 s
    share = np.clip((12.1 - kept.time.values[:-1]) / 0.25, 0.0, 1.0)
    expected = share * before + (1.0 - share) * after
    # where the curve has a kink within a period, its mean speed is not quite the middle
    np.testing.assert_allclose(friction[fast], expected[fast], rtol=2e-4)


def test_metrics_are_those_of_the_history(small, table, kept, scenario):
    row = {name: values[5] for name, values in table.items()}
    assert row["status"] == 0
    time, torque = kept.time.values, kept.torque.values
    counts = time >= 2.0 - 1e-9
    # the boresight is the body's x: its direction from the quaternion, by hand
    w, x, y, z = kept.attitude.values.T
    seen = np.stack([1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
    angle = 2.0 * np.arctan2(0.002, 1.0)
    target = np.where(
        time[:, None] >= 18.0 - 1e-9, [np.cos(angle), np.sin(angle), 0.0], [1.0, 0.0, 0.0]
    )
    error = np.arctan2(
        np.linalg.norm(np.cross(seen, target), axis=1), np.sum(seen * target, axis=1)
    )
    np.testing.assert_allclose(kept.error.values, error, atol=1e-12)
    ordered = np.sort(error[counts])
    for p in scenario.percentiles:
        # the same number as in the history, none between
        exact = np.percentile(kept.error.values[counts], p, method="inverted_cdf")
        assert row[f"error_p{p:g}"] == exact
    speed = kept.wheel_speed.values
    sense = np.sign(speed)
    crossing = ((sense[1:] != sense[:-1]) & (sense[:-1] != 0.0) & counts[1:, None]).sum(axis=1)
    at = time[1:][crossing > 0]
    near = np.any((time[:, None] >= at) & (time[:, None] <= at + 3.0 + 1e-9), axis=1)
    rate = np.linalg.norm(kept.rate.values, axis=1)
    out = (error >= np.radians(0.1)) | (rate >= np.radians(0.01))
    settled = np.nan if out[-1] else time[len(out) - np.argmax(out[::-1])]
    expected = {
        "error_max": ordered[-1],
        "error_rms": np.sqrt(np.mean(ordered**2)),
        "error_end": error[-1],
        "crossings": crossing.sum(),
        "crossing_peak": error[near & counts].max(),
        "momentum_peak": np.max(np.abs(2.0e-5 * speed)),
        "torque_peak": np.max(np.abs(torque)),
        "torque_rms": np.sqrt(np.mean(torque**2)),
        "energy": 0.25 * np.sum(np.abs(torque * speed)),
        "saturated": np.mean(np.any((np.abs(torque) >= 0.999e-3) | kept.saturated, axis=1)),
        "settling": settled,
        "ended": 30.0,
    }
    assert expected["crossings"] > 0
    for name, value in expected.items():
        np.testing.assert_allclose(row[name], value, rtol=1e-9, err_msg=name)


def test_metrics_of_windows_are_those_of_the_history(table, kept, scenario):
    row = {name: values[5] for name, values in table.items()}
    time, y = kept.time.values, kept.attitude.values[:, 1:].T
    begin = 12.1 + row["window.imaging.from"]
    inside = (time >= begin - 1e-9) & (time <= 19.0 + 1e-9)
    # the slew at 18 s turns the reference about the body's z
    angle = np.where(time >= 18.0 - 1e-9, 2.0 * np.arctan2(0.002, 1.0), 0.0)
    w = kept.attitude.values[:, 0]
    seen = np.stack([2 * (y[0] * y[1] - w * y[2]), 1 - 2 * (y[0] ** 2 + y[2] ** 2)])
    seen = np.stack([*seen, 2 * (y[1] * y[2] + w * y[0])], axis=1)
    target = np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    error = np.arcsin(np.linalg.norm(np.cross(seen, target), axis=1))
    rate = np.linalg.norm(kept.rate.values, axis=1)
    slow = np.abs(kept.wheel_speed.values) <= 20 * 2 * np.pi / 60
    expected = {
        "imaging.error_p95": np.percentile(error[inside], 95, method="inverted_cdf"),
        "imaging.error_max": error[inside].max(),
        "imaging.error_rms": np.sqrt(np.mean(error[inside] ** 2)),
        "imaging.error_end": error[time <= 19.0 + 1e-9][-1],
        "imaging.rate_error_rms": np.sqrt(np.mean(rate[inside] ** 2)),
        "imaging.dwell": np.mean(slow[inside].any(axis=1)),
        "imaging.dwell.b": np.mean(slow[inside, 1]),
        "turning.error_end": row["error_end"],
        "turning.error_max": kept.error.values[time >= 18.0 - 1e-9].max(),
    }
    assert expected["imaging.dwell"] > 0.0
    for name, value in expected.items():
        np.testing.assert_allclose(row[name], value, rtol=1e-9, err_msg=name)
    assert row["turning.error_end"] == row["error_end"]
    late = table["settling"] >= 18.0
    np.testing.assert_allclose(
        table["turning.settling"][late] + 18.0, table["settling"][late], rtol=1e-12
    )
    assert np.sum(late) > 0
    assert np.all(table["imaging.smear"][table["status"] == 0] > 0.0)


def test_a_lost_wheel_gives_no_more_torque_and_then_gets_none(kept, table):
    lost = table["event.loss.time"][5]
    time, c = kept.time.values, 2
    momentum = 2.0e-5 * kept.wheel_speed.values[:, c]
    told = kept.torque.values[:, c]
    assert np.all(told[time >= lost + 1.0 + 0.25] == 0.0)
    assert np.any(told[(time >= lost) & (time < lost + 1.0)] != 0.0)
    # it runs down by its own friction: dh/dt = -F(W), and a turn of the body moves it hardly
    after = (time > lost + 0.25) & (np.abs(momentum) > 1e-6)
    fall = np.diff(np.abs(momentum[after])) / 0.25
    coulomb = table["wheel.c.coulomb"][5]
    speed = np.abs(kept.wheel_speed.values[:, c])[after]
    speed = 0.5 * (speed[1:] + speed[:-1])
    friction = coulomb + (3.0e-5 - coulomb) * np.exp(-((speed / 2.0) ** 2)) + 1.0e-7 * speed
    np.testing.assert_allclose(fall, -friction, rtol=0.01)


def test_runs_that_diverge_are_told_with_their_time(small, table):
    diverged = np.flatnonzero(table["status"] == Status.DIVERGED)
    assert 0 < len(diverged) < 30
    assert np.all(table["ended"][diverged] < 30.0)
    assert np.all(table["ended"][diverged] > 0.0)
    assert np.all(np.isnan(table["error_max"][diverged]))
    # J dw/dt = T about a principal axis: the rate of no return, 10 rad/s, is reached at 10 J / T
    torque = table["environment.external_torque.x"][diverged]
    alone = torque > 20e-3  # the wheels, 1 mN·m each, are next to nothing
    expected = 10.0 * 0.06 / torque[alone]
    assert np.any(alone)
    np.testing.assert_allclose(table["ended"][diverged][alone], expected, rtol=0.25, atol=0.3)
    others = table["status"] == 0
    assert np.all(np.isfinite(table["error_max"][others]))
    worst = worst_runs(small.store, len(diverged) + 1, "error_p99.7")
    assert set(worst[:-1]) == set(diverged)
    assert table["error_p99.7"][worst[-1]] == np.nanmax(table["error_p99.7"])
    assert small.store.history(worst[0]).exists()


def test_momentum_changes_by_the_torque_from_outside_alone(kept, table):
    momentum, (w, x, y, z) = kept.momentum.values, kept.attitude.values.T
    turned = np.stack([1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1)
    torque = table["environment.external_torque.x"][5] * turned
    gained = 0.25 * np.cumsum(0.5 * (torque[1:] + torque[:-1]), axis=0)
    np.testing.assert_allclose(momentum[1:] - momentum[0], gained, atol=1e-9 * 30.0)


def test_errors_that_do_not_fit_in_memory_are_counted_in_bins(small, table):
    """The worker's limit is set to nothing for one flight."""
    limit = "import gyrostat.runs.metrics.percentiles as p; p.MEMORY = {}"
    small.pool.submit(exec, limit.format(0.0)).result()
    try:
        binned = small.fly(4, 5, 6).columns
    finally:
        small.pool.submit(exec, limit.format(200e6)).result()
    for name, values in binned.items():
        if "error_p" in name:
            assert np.any(values != table[name][4:7])
            assert not np.any(values > binned[f"{name.split('error_p')[0]}error_max"])
        if "error_p" in name or name in ("requirement.rpe", "requirement.pde"):
            np.testing.assert_allclose(values, table[name][4:7], rtol=1e-3, err_msg=name)
        else:
            np.testing.assert_array_equal(values, table[name][4:7], err_msg=name)


def test_no_percentile_exceeds_the_maximum(table, scenario):
    for p in scenario.percentiles:
        assert not np.any(table[f"error_p{p:g}"] > table["error_max"])


def test_a_run_that_diverges_at_its_start_ends_at_its_start():
    seen = SimpleNamespace(samples=np.array([0, 1, 121]))
    np.testing.assert_array_equal(ended(seen, 0.25), [0.0, 0.0, 30.0])


def test_the_worst_of_equal_runs_has_the_largest_maximum():
    columns = {
        "run": np.arange(5),
        "status": np.array([0, 0, 0, 1, 0], np.int8),
        "ended": np.array([9.0, 9.0, 9.0, 4.0, 9.0]),
        "error_p50": np.array([1.0, 2.0, 2.0, np.nan, 2.0]),
        "error_max": np.array([9.0, 3.0, 5.0, np.nan, 4.0]),
    }
    store = SimpleNamespace(columns=lambda: columns)
    assert worst_runs(store, 4, "error_p50") == [3, 2, 4, 1]


def test_an_engine_that_there_is_not_is_refused(scenario, tmp_path):
    with pytest.raises(InputError, match="found 'lane', expected one of auto, native, jax"):
        run_campaign(scenario, tmp_path, runs=2, engine="lane")


def test_requirements_are_those_of_the_history(table, kept):
    """Pointing error of x, full rotation vectors, and windows that begin with events."""
    row = {name: values[5] for name, values in table.items()}
    time, attitude = kept.time.values, kept.attitude.values
    target = np.where(time[:, None] >= 18.0, [1.0, 0.0, 0.0, 0.002], [1.0, 0.0, 0.0, 0.0])
    actual, wanted, measured = (
        Rotation.from_quat(each, scalar_first=True)
        for each in (attitude, target, kept.measured_attitude.values)
    )
    counted = time >= 2.0
    error = kept.error.values[counted]
    share = np.mean(error > np.radians(0.2))
    assert row["requirement.ape"] == pytest.approx(share, abs=1e-12)
    sizes = counted_sizes(np.radians(0.2)) * np.radians(0.2)
    shares = np.mean(error[:, None] <= sizes, axis=0)
    np.testing.assert_allclose(row["requirement.ape.shares"], shares, rtol=1e-6)
    places = instants(121)
    profile = np.where(time >= 2.0, kept.error.values, np.nan)[places]
    np.testing.assert_allclose(row["error.profile"], profile, rtol=1e-6)
    known = (actual.inv() * measured).magnitude()
    assert row["requirement.ake"] == pytest.approx(np.max(known[counted]), rel=1e-9)
    turn = (wanted.inv() * actual).as_rotvec()
    mean = {k: np.trapezoid(turn[k - 4 : k + 1], axis=0) / 4.0 for k in range(4, 121)}
    begin, end = 12.1 + row["window.imaging.from"], 12.1 + 6.9
    # the windows overlap: imaging ends at 19 s, turning begins with the slew at 18 s
    imaging = [k for k in range(121) if begin - 1e-9 <= time[k] <= end + 1e-9]
    turning = [k for k in range(121) if time[k] >= 18.0]
    relative = [
        abs(turn[e - j, 1] - mean[e][1])
        for samples in (imaging, turning)
        for e in samples[4::4]
        for j in range(4 + (e == samples[4]))
    ]
    expected = np.quantile(relative, 0.9, method="inverted_cdf")
    assert row["requirement.rpe"] == pytest.approx(expected, rel=1e-9)
    between = np.linalg.norm(mean[turning[4]] - mean[imaging[4]])
    assert row["requirement.between"] == pytest.approx(between, rel=1e-9)
