"""Dimensions, coordinates and attributes of histories."""

from collections import namedtuple
from dataclasses import replace

import h5py
import numpy as np
import pytest
import xarray as xr
from scipy.spatial.transform import Rotation

from gyrostat.simulation import Histories, labelled
from gyrostat.simulation.labelled import Signal, joined
from gyrostat.spacecraft import GyrostatRecord, GyrostatState, SpacecraftMeasurement

RUNS, TIMES, PERIOD = 2, 5, 0.5
Command = namedtuple("Command", ["torque", "target", "own"])
Command.UNITS = {"torque": "N·m"}


def random_signals(wheels):
    random = np.random.default_rng(0)

    def draw(*shape):
        return random.standard_normal((RUNS, TIMES, *shape))

    attitude = Rotation.random(RUNS * TIMES, rng=random).as_quat(scalar_first=True)
    attitude = attitude.reshape(RUNS, TIMES, 4)
    near = Rotation.from_rotvec([1e-9, 0.0, 0.0]) * Rotation.from_quat(
        attitude.reshape(-1, 4), scalar_first=True
    )
    target = -near.as_quat(scalar_first=True).reshape(RUNS, TIMES, 4)
    target[0] = attitude[0, ::-1]
    return Histories(
        state=GyrostatState(attitude, draw(3), draw(wheels)),
        measurement=SpacecraftMeasurement(
            attitude, draw(3), draw(wheels), np.ones((RUNS, TIMES, wheels), bool)
        ),
        command=Command(draw(wheels), target, draw(2)),
        record=GyrostatRecord(draw(3), draw(wheels), np.zeros((RUNS, TIMES, wheels), bool)),
        status=np.array([[0] * TIMES, [0, 0, 0, 1, 1]]),
    )


@pytest.mark.parametrize("wheels", [1, 3, 4])
def test_every_number_is_found_by_name(wheels):
    signals = random_signals(wheels)
    data = labelled(signals, PERIOD).dataset()
    assert data.attitude.dims == ("run", "time", "quaternion")
    for name in ("momentum", "rate", "measured_rate"):
        assert data[name].dims == ("run", "time", "axis")
    for name in ("wheel_speed", "wheel_momentum", "torque", "saturated", "measured_wheel_speed"):
        assert data[name].dims == ("run", "time", "wheel")
    assert data.own.dims == ("run", "time", "own_1")
    now = data.sel(run=0, time=1.0)
    assert now.rate.sel(axis="y") == signals.record.rate[0, 2, 1]
    assert now.attitude.sel(quaternion="w") == signals.state.attitude[0, 2, 0]
    assert now.wheel_speed.sel(wheel=wheels - 1) == signals.state.wheel_speed[0, 2, -1]


def test_signals_have_units_and_long_names():
    data = labelled(random_signals(3), PERIOD).dataset()
    assert data.wheel_speed.attrs == {"long_name": "wheel speed", "units": "rad/s"}
    assert data.measured_rate.attrs["long_name"] == "measured body rate, body axes"
    assert data.own.attrs == {"long_name": "own"}
    for name in data.variables:
        assert "long_name" in data[name].attrs or name in ("run", "axis", "quaternion", "wheel")


def test_the_error_is_the_angle_to_the_target():
    signals = random_signals(3)
    data = labelled(signals, PERIOD).dataset()
    first, second = (
        Rotation.from_quat(q.reshape(-1, 4), scalar_first=True)
        for q in (signals.state.attitude, signals.command.target)
    )
    angle = (first.inv() * second).magnitude().reshape(RUNS, TIMES)
    fine = signals.status == 0
    # an angle of 1e-9 rad, too, of quaternions of other signs
    np.testing.assert_allclose(data.error.values[fine], angle[fine], rtol=1e-6, atol=1e-15)
    assert np.isnan(data.error.values[~fine]).all()
    assert data.error.units == "rad"


def test_a_target_that_is_no_attitude_is_left_alone():
    signals = random_signals(3)
    other = signals.command._replace(target=np.zeros((RUNS, TIMES)))
    assert "error" not in labelled(signals._replace(command=other), PERIOD).variables


def named_runs():
    """Histories of the runs 4 and 7, whose wheels have names."""
    data = labelled(random_signals(2), PERIOD)
    own = {"run": np.array([4, 7]), "wheel": np.array(["a", "bö"])}
    named = {name: Signal((name,), values) for name, values in own.items()}
    return replace(data, coordinates={**data.coordinates, **named}, attributes={"about": "runs"})


def test_one_run_and_joined_runs_are_those_of_xarray():
    data = named_runs()
    assert data.of_run(7).dataset().identical(data.dataset().sel(run=7))
    other = replace(data, coordinates={**data.coordinates, "run": Signal(("run",), np.arange(2))})
    both = [data, other]
    assert joined(both).dataset().identical(xr.concat([each.dataset() for each in both], "run"))


def test_a_file_is_that_of_xarray(tmp_path):
    data = named_runs().of_run(4)
    data.write(tmp_path / "run.nc")
    data.dataset().to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with xr.open_dataset(tmp_path / "run.nc", engine="h5netcdf") as found:
        assert found.load().identical(data.dataset())
        assert found.wheel_speed.sel(wheel="bö").dims == ("time",)
    files = h5py.File(tmp_path / "run.nc"), h5py.File(tmp_path / "other.nc")
    with files[0] as ours, files[1] as theirs:
        assert set(ours) == set(theirs)
        assert texts(ours) == texts(theirs)
        for name in theirs:
            assert ours[name].dtype == theirs[name].dtype
            assert texts(ours[name]) == texts(theirs[name])


def texts(item):
    """Attributes of a file or of an array in it; the links between arrays depend on their order."""
    links = {"DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "_Netcdf4Coordinates"}
    return {name: repr(value) for name, value in item.attrs.items() if name not in links}
