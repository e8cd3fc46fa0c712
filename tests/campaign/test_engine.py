"""Runs of the small campaign: the same bits however they are flown, metrics as their histories."""

import numpy as np
import pytest
import xarray as xr

from gyrostat.campaign import run_campaign, worst_runs
from gyrostat.campaign.execute import chosen_engine
from gyrostat.campaign.metrics import BINS, LEAST_ERROR, WIDTH, percentile
from gyrostat.errors import InputError
from gyrostat.lanes import compiler as compiler_found
from gyrostat.simulate import Status


@pytest.fixture(scope="module")
def table(small):
    """Name -> (runs,) of every run."""
    found = small.store.read_table()
    return {name: found[name].to_numpy() for name in found.column_names}


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
        np.testing.assert_allclose(values, table[name][runs], rtol=1e-11, atol=1e-14, err_msg=name)


def test_without_a_compiler_jax_flies_and_it_is_said_once(scenario, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    compiler_found.cache_clear()
    said = []
    try:
        assert chosen_engine("auto", scenario.text(), "cpu", said.append) == "jax"
        assert chosen_engine("auto", scenario.text(), "gpu", said.append) == "jax"
        assert len(said) == 1
        assert "C compiler: found none" in said[0]
        with pytest.raises(InputError, match="C compiler: found none"):
            chosen_engine("lanes", scenario.text(), "cpu")
        with pytest.raises(InputError, match="expected cpu: lanes are C"):
            chosen_engine("lanes", scenario.text(), "gpu")
    finally:
        compiler_found.cache_clear()


def test_another_engine_than_the_recorded_one_is_refused(small, scenario):
    other = "jax" if small.engine == "lanes" else "lanes"
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
        exact = ordered[int(np.ceil(p / 100.0 * len(ordered))) - 1]
        np.testing.assert_allclose(row[f"error_p{p:g}"], exact, rtol=0.5 * WIDTH + 1e-3)
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
        "saturated": np.mean(np.any(np.abs(torque) >= 0.999e-3, axis=1)),
        "settling": settled,
        "ended": 30.0,
    }
    assert expected["crossings"] > 0
    for name, value in expected.items():
        np.testing.assert_allclose(row[name], value, rtol=1e-9, err_msg=name)


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


def test_percentiles_of_a_histogram():
    error = np.random.default_rng(1).lognormal(-7.0, 1.0, 5000)
    bins = np.floor(np.log(error / LEAST_ERROR) / np.log1p(WIDTH)).astype(int)
    histogram = np.bincount(bins, minlength=BINS)[None]
    for p in (5.0, 50.0, 99.7):
        exact = np.sort(error)[int(np.ceil(p / 100.0 * len(error))) - 1]
        found = percentile(histogram, p, np.array([len(error)]))
        np.testing.assert_allclose(found, exact, rtol=0.5 * WIDTH + 1e-3)
    assert np.isnan(percentile(histogram * 0, 50.0, np.array([0])))[0]
