"""Telemetry of fleets: rounding, gaps, repeats, rates; faults against their definitions."""

import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet
import pytest

from gyrostat.monitoring.fleet.files import write_fleet
from gyrostat.monitoring.fleet.flight import FAULTS, Cell, Fleet, Flight
from gyrostat.monitoring.fleet.pointing import LOW, SLEWS, matrix
from gyrostat.monitoring.fleet.sampling import RPM, UGLY, Sampling, sample
from gyrostat.monitoring.fleet.vehicle import SMALL
from gyrostat.spacecraft.spacecraft_file import read_spacecraft


@pytest.fixture(scope="module")
def day():
    """One day of a small spacecraft."""
    return next(Fleet(Cell(SMALL, LOW, SLEWS), [Flight(1)]).days(1))[0]


def test_speeds_and_currents_are_rounded(day):
    columns = sample(day, SMALL, Sampling())
    for name, step in (("wheel2_speed_rpm", 0.4), ("wheel2_current_A", 1e-3)):
        counts = columns[name] / step
        assert np.max(np.abs(counts - np.round(counts))) < 5e-3
    assert np.max(np.abs(columns["wheel2_speed_rpm"] * RPM - day.speed[:, 1])) < 0.201 * RPM


def test_attitude_is_the_commanded_one_turned_by_the_error(day):
    columns = sample(day, SMALL, Sampling())
    attitude, target = (
        np.stack([columns[f"{kind}_{k}"] for k in "wxyz"], axis=1)
        for kind in ("attitude", "commanded")
    )
    turned = np.einsum("nji,njk->nik", matrix(target[:500]), matrix(attitude[:500]))
    turned = (turned - turned.transpose(0, 2, 1)) / 2.0
    angle = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=1)
    assert np.allclose(angle, day.angle[:500], atol=1e-6)
    # the matrices of the fleet are those of its quaternions
    assert np.allclose(matrix(target), day.commanded.to_inertial, atol=1e-9)


def test_commanded_rate_is_the_derivative_of_the_attitude(day):
    path = day.commanded
    change = np.einsum("nji,njk->nik", path.to_inertial[:-2], path.to_inertial[2:])
    change = (change - change.transpose(0, 2, 1)) / 4.0
    rate = np.stack([change[:, 2, 1], change[:, 0, 2], change[:, 1, 0]], axis=1)
    assert np.allclose(rate, path.rate[1:-1], rtol=0.0, atol=5e-6)
    slope = (path.rate[2:] - path.rate[:-2]) / 2.0
    assert np.allclose(slope, path.acceleration[1:-1], rtol=0.0, atol=3e-5)


@pytest.mark.parametrize("period", [0.1, 0.5, 5.0])
def test_other_rates_show_the_same_motion(day, period):
    columns = sample(day, SMALL, replace(Sampling(), period=period, speed_step=1e-6))
    speed = np.interp(day.time, columns["time_s"], columns["wheel1_speed_rpm"] * RPM)
    assert columns["time_s"].size == round(86400.0 / period)
    assert np.max(np.abs(speed - day.speed[:, 0])[100:-10]) < 0.2


def test_ugly_telemetry_lacks_a_fifth_and_repeats_rows(day):
    columns = sample(day, SMALL, replace(UGLY, gap_share=0.2))
    time = columns["time_s"]
    share = 1.0 - np.unique(time).size / 86400.0
    assert 0.08 < share < 0.35
    assert np.any(np.diff(time) == 0.0)
    assert {values.size for values in columns.values()} == {time.size}


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_changes_its_parameter_alone(name):
    kind = FAULTS[name]
    fault = kind(wheel=2, day=3.0, size=kind.usual_size, duration=kind.usual_duration, seed=1)
    cell = Cell(SMALL, LOW, SLEWS)
    time = np.arange(0.0, 40.0, 1.0 / 1440.0)
    healthy, faulty = (
        flight.slow(cell, time, np.full(time.shape, 20.0))
        for flight in (Flight(1), Flight(1, (fault,)))
    )
    changed = {
        (wheel, key)
        for wheel in range(4)
        for key in healthy[0]
        if not np.allclose(healthy[wheel][key], faulty[wheel][key], rtol=1e-12, atol=0.0)
    }
    assert len(changed) == 1
    ((wheel, key),) = changed
    assert wheel == 2
    before = time < 3.0
    assert np.allclose(healthy[2][key][before], faulty[2][key][before], rtol=1e-12)


def test_files_of_a_fleet(tmp_path):
    fault = FAULTS["offset"](wheel=1, day=0.5, size=0.3)
    fleet = Fleet(Cell(SMALL, LOW, SLEWS), [Flight(4, (fault,))])
    write_fleet(tmp_path, fleet, 1, Sampling(period=10.0))
    folder = tmp_path / "flight4"
    table = pyarrow.parquet.read_table(folder / "telemetry.parquet")
    truth = pyarrow.parquet.read_table(folder / "truth.parquet").to_pylist()
    assert table.num_rows == 8640
    offset = Flight(4).wheels(fleet.cell)["offset"]
    assert truth[1]["offset"] == pytest.approx(offset[1] + 0.15 * SMALL.wheel.coulomb)
    assert json.loads((folder / "events.json").read_text())[0]["class"] == "offset"
    spacecraft = read_spacecraft(folder / "spacecraft.toml").spacecraft
    assert np.asarray(spacecraft.wheels.axes) == pytest.approx(SMALL.axes)
