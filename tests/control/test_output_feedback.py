"""The loop closed on estimates, flown on an ideal body."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import AttitudeTargets, OutputFeedback, PseudoInverse, WheelArrayControl
from gyrostat.core.errors import InputError
from gyrostat.estimation import AttitudeFilter
from gyrostat.simulation import Status, simulate
from gyrostat.spacecraft import (
    Gyrostat,
    RateGyro,
    Spacecraft,
    SpacecraftSensor,
    StarTracker,
    TrackerGyroSensors,
)
from gyrostat.wheel import WheelArray, pyramid_axes

WHEELS = WheelArray(pyramid_axes(4), np.full(4, 2e-5), np.full(4, 3e-3), np.full(4, 1.5e-2))
CRAFT = Spacecraft(np.diag([0.12, 0.10, 0.06]), WHEELS)
SIGMA, ANGLE, BIAS = 1e-4, 1e-5, 1e-7
TARGET = np.array([0.8, 0.0, 0.6, 0.0])
PERIOD = 0.25


@pytest.fixture(scope="module")
def flight(frictionless):
    """From rest to a target 74 degrees away, with a gyro whose bias the filter does not know."""
    plant = Gyrostat(CRAFT)
    control = WheelArrayControl(CRAFT, AttitudeTargets.hold(TARGET), allocation=PseudoInverse())
    data = simulate(
        frictionless(plant),
        OutputFeedback(AttitudeFilter(SIGMA, ANGLE, BIAS, 1e-3), control),
        TrackerGyroSensors(
            SpacecraftSensor(plant),
            StarTracker(SIGMA, 4),
            RateGyro(ANGLE, BIAS, np.array([8e-4, -5e-4, 1e-3])),
        ),
        start=plant.start(),
        duration=300.0,
        control_period=PERIOD,
        seed=4,
    )
    assert data.status == Status.COMPLETE
    return data


def turn_between(first, second):
    first, second = (Rotation.from_quat(q, scalar_first=True) for q in (first, second))
    return (second.inv() * first).as_rotvec()


def test_the_target_is_reached_on_estimates_alone(flight):
    """Better than a sample of the star tracker, with a bias that alone would be 10 mrad off."""
    last = flight.isel(time=slice(-400, None))
    truth = turn_between(last.attitude.values, np.tile(TARGET, (400, 1)))
    assert np.sqrt(np.mean(truth**2)) < SIGMA
    assert np.allclose(last.estimated_bias[-1], [8e-4, -5e-4, 1e-3], atol=2e-5)


def test_the_estimate_errs_as_it_says(flight):
    lacks = turn_between(flight.attitude.values, flight.estimated_attitude.values)[20:]
    share = lacks / flight.attitude_sigma.values[20:]
    assert 0.5 < np.sqrt(np.mean(share**2)) < 1.5
    assert np.max(np.abs(share)) < 5.0


def test_everything_is_recorded_with_its_unit(flight):
    assert flight.estimated_bias.attrs["units"] == "rad/s"
    assert flight.torque.attrs["units"] == "N·m"
    assert {"innovation", "surprise", "works", "target"} <= set(flight.data_vars)


def test_what_a_part_refuses_is_refused():
    control = WheelArrayControl(CRAFT, AttitudeTargets.hold(TARGET), turn_gain=-1.0)
    with pytest.raises(InputError, match="turn gain"):
        OutputFeedback(AttitudeFilter(SIGMA, ANGLE, BIAS, 1e-3), control).check()
    with pytest.raises(InputError, match="angle walk"):
        OutputFeedback(AttitudeFilter(SIGMA, 0.0, BIAS, 1e-3), control).check()
    with pytest.raises(InputError, match="control period"):
        OutputFeedback(AttitudeFilter(SIGMA, ANGLE, BIAS, 1e-3), control).check_period(10.0)
