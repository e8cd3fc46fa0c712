"""Rehearsal: spacecraft of a user, counts, and arguments that cannot be used."""

import numpy as np
import pytest
import scipy.stats

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.monitoring.fleet.files import spacecraft_text, wheels_text
from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.pointing import LOW, SLEWS
from gyrostat.monitoring.fleet.sampling import Sampling
from gyrostat.monitoring.fleet.user_vehicle import assumptions, user_vehicle
from gyrostat.monitoring.fleet.vehicle import LARGE
from gyrostat.monitoring.rehearsal import Expected, Rehearsal
from gyrostat.monitoring.wheels_file import read_wheels


@pytest.fixture(params=[3, 4, 2])
def files(request, tmp_path):
    """Spacecraft file and wheels file with a number of wheels."""
    count = request.param
    spacecraft = spacecraft_text(LARGE).split("\n[[wheel]]")
    (tmp_path / "sat.toml").write_text("\n[[wheel]]".join(spacecraft[: count + 1]), "utf-8")
    wheels = wheels_text(known_wheels(LARGE, Sampling())).split("\n[[wheel]]")
    (tmp_path / "wheels.toml").write_text("\n[[wheel]]".join(wheels[: count + 1]), "utf-8")
    return count, tmp_path / "sat.toml", tmp_path / "wheels.toml"


def test_spacecraft_of_a_user_flies(files):
    count, spacecraft, wheels = files
    known = read_wheels(wheels, spacecraft)
    if count == 2:
        with pytest.raises(InputError, match=r"found 2 wheels, expected three or four"):
            user_vehicle(spacecraft, known)
        return
    vehicle = user_vehicle(spacecraft, known)
    assert np.sort(vehicle.inertia) == pytest.approx(np.sort(LARGE.inertia))
    assert vehicle.axes.T @ vehicle.axes == pytest.approx(
        LARGE.axes.T[:count] @ LARGE.axes[:, :count]
    )
    assert len(assumptions(vehicle)) == 5
    if count == 4:
        return  # as all other fleets
    day = next(Fleet(Cell(vehicle, LOW, SLEWS), [Flight(1)]).days(1))[0]
    assert day.speed.shape == (86400, count)
    assert np.max(np.abs(day.angle)) < 0.02
    assert np.max(np.abs(day.torque)) < vehicle.wheel.torque_limit


def test_rate_of_false_alarms_has_its_poisson_interval():
    found = Rehearsal(20.0, 3, {}, {}, {})
    low, high = found.rate()
    # the limits are the rates at which 3 or more, or 3 or fewer, have a chance of 2.5 %
    assert scipy.stats.poisson(20.0 * low).sf(2) == pytest.approx(0.025)
    assert scipy.stats.poisson(20.0 * high).cdf(3) == pytest.approx(0.025)
    assert Rehearsal(20.0, 0, {}, {}, {}).rate()[0] == 0.0


def test_text_of_a_rehearsal():
    sigma = dict.fromkeys(("coulomb", "viscous", "motor_constant", "offset"), 0.01)
    faults = {"offset": Expected(0.1, 4, 1, np.inf, 0, 1)}
    found = Rehearsal(1.0, 0, sigma, sigma, faults, ("quiet",))
    text = "\n".join(found.lines())
    assert "offset of 0.1: alarm in 1 of 4 wheels, median delay none, class right in 0" in text
    assert "one of two or three in 1" in text
    assert found.as_json()["faults"]["offset"]["median_delay_days"] is None


def test_arguments_that_cannot_be_used(files):
    _, spacecraft, wheels = files
    with pytest.raises(InputError, match=r"period: found 60 s, expected 0\.1 s to 10 s"):
        gs.monitor(rehearse=spacecraft, wheels=wheels, period="60s")
    with pytest.raises(InputError, match=r"rehearse: found telemetry too"):
        gs.monitor("a.csv", rehearse=spacecraft, wheels=wheels)
    with pytest.raises(InputError, match=r"telemetry: found no file"):
        gs.monitor(wheels=wheels)
