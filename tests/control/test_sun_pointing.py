"""Sun pointing: capture from any side, damping without the Sun, and the designed poles."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control.attitude.sun_condition import SunCondition
from gyrostat.control.attitude.sun_pointing import SunPointing, measured_sun
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import AddedSensors, Gyrostat, Spacecraft, SpacecraftSensor
from gyrostat.spacecraft.sensors.sampled import Sampled
from gyrostat.spacecraft.sensors.sun_sensor import CoarseSunSensors, SunSensor
from gyrostat.wheel import WheelArray, pyramid_axes
from tests.spacecraft import orbit_samples

WHEELS = WheelArray(pyramid_axes(4), np.full(4, 1e-4), np.full(4, 5e-3), np.full(4, 0.2))
CRAFT = Spacecraft(np.array([[0.2, 0.01, 0.0], [0.01, 0.22, 0.0], [0.0, 0.0, 0.12]]), WHEELS)
AXIS = np.array([0.0, 0.6, 0.8])
PERIOD, COUNT = 0.5, 800
STARTS = {
    "beside": ([0.0, 0.4, 0.3], [0.01, -0.01, 0.02]),
    "opposite": (None, [0.0, 0.0, 0.0]),
    "umbra": ([0.0, 0.4, 0.3], [0.01, -0.01, 0.02]),
}


@pytest.fixture(scope="module")
def captured(frictionless):
    """Runs with an ideal sensor: Sun beside, exactly opposite, and in the umbra; and the orbit."""
    orbit, plant = orbit_samples.noon(6000.0), Gyrostat(CRAFT)
    half = 0.5 * float(orbit.period)
    starts, sensors = [], []
    for name, (turn, rate) in STARTS.items():
        turn = opposite(orbit) if turn is None else turn
        attitude = Rotation.from_rotvec(turn).as_quat(scalar_first=True)
        starts.append(plant.start(attitude=attitude, rate=rate, wheel_speed=100.0))
        time = half - 200.0 if name == "umbra" else 0.0
        moved = type(orbit)(orbit.splines, orbit.step, orbit.period, np.array(time))
        sensor = SpacecraftSensor(plant)
        sensors.append(AddedSensors(sensor, {"sun_sensor": Sampled(SunSensor(moved))}))
    found = simulate(
        frictionless(plant),
        SunPointing(CRAFT, AXIS),
        stack(sensors),
        start=stack(starts),
        duration=PERIOD * COUNT,
        control_period=PERIOD,
        runs=3,
        engine="jax",
    )
    return found, orbit


def opposite(orbit):
    """Rotation vector that brings the axis to the direction away from the Sun at time 0."""
    away = np.array(jax.jit(lambda time: orbit.position(time) - orbit.sun(time))(0.0))
    away = away / np.linalg.norm(away)
    normal = np.cross(AXIS, away)
    return normal / np.linalg.norm(normal) * np.arccos(AXIS @ away)


def angle_to_sun(found):
    """Angle between axis and Sun, which is along x, rad; the parallax is below 5e-5 rad."""
    axis = Rotation.from_quat(found.attitude.values, scalar_first=True).apply(AXIS)
    return np.arccos(np.clip(axis[:, 0], -1.0, 1.0))


@pytest.mark.parametrize("number", [0, 1])
def test_the_axis_points_to_the_sun(captured, number):
    found = captured[0].isel(run=number)
    angle = angle_to_sun(found)
    assert angle[0] > (1.0, 3.14)[number]
    assert angle[-1] < 2e-4
    assert np.linalg.norm(found.rate.values[-1]) < 1e-5
    # the commanded rate is limited
    assert np.linalg.norm(found.rate.values[50:], axis=1).max() < 0.021


def test_without_the_sun_the_body_comes_to_rest(captured):
    found = captured[0].isel(run=2)
    assert np.all(found.sun_sensor == 0.0)
    rate = np.linalg.norm(found.rate.values, axis=1)
    # the momentum does not turn with the body: w' = -k w, held over a period
    expected = rate[0] * (1.0 - 0.2 * PERIOD) ** np.arange(20)
    np.testing.assert_allclose(rate[:20], expected, rtol=0.03)
    assert rate[-1] < 1e-6
    assert angle_to_sun(found)[-1] > 0.2


def test_the_momentum_of_body_and_wheels_is_conserved(captured):
    momentum = captured[0].momentum.values
    np.testing.assert_allclose(
        momentum, np.broadcast_to(momentum[:, :1], momentum.shape), rtol=1e-9
    )


def test_cells_on_six_faces_give_the_direction():
    orbit = orbit_samples.noon(100.0)
    attitude = Rotation.from_rotvec([0.3, -0.8, 1.1]).as_quat(scalar_first=True)

    @jax.jit
    def measured(attitude):
        """Direction by cells, by cells of a hundredth of the light, and by an ideal sensor."""
        state, key = SimpleNamespace(attitude=attitude), jax.random.key(1)
        cells = CoarseSunSensors(orbit)(state, 10.0, key)
        seen, dark = (
            measured_sun(SimpleNamespace(coarse_sun_sensors=share * cells)) for share in (1.0, 0.01)
        )
        return seen, dark, SunSensor(orbit)(state, 10.0, key)

    seen, dark, ideal = measured(attitude)
    np.testing.assert_allclose(seen, ideal, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(dark, 0.0)


def test_the_search_rate_is_kept_while_the_sun_is_not_seen():
    law = SunPointing(CRAFT, AXIS, search_rate=np.array([0.0, 0.01, 0.0]))
    law.check()
    seen = SimpleNamespace(
        sun_sensor=np.zeros(3), rate=np.array([0.0, 0.01, 0.0]), wheel_speed=np.zeros(4)
    )
    _, command = law((), seen)
    momentum = np.asarray(CRAFT.inertia_locked()) @ seen.rate
    np.testing.assert_allclose(
        WHEELS.axes @ command.torque, -np.cross(seen.rate, momentum), atol=1e-9
    )


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="axis of the sun pointing: found no direction"):
        SunPointing(CRAFT, np.zeros(3)).check()
    with pytest.raises(
        InputError, match=r"sun pointing: found a measurement of .* field sun_sensor"
    ):
        SunPointing(CRAFT)((), SimpleNamespace(rate=np.zeros(3), wheel_speed=np.zeros(4)))


def test_sun_condition_is_that_of_the_angle():
    """Against the arc cosine, for both senses; where the Sun is not seen, only that it is lost."""
    random = np.random.default_rng(4)
    axis, *directions = random.normal(size=(21, 3))
    for sun in [each / np.linalg.norm(each) for each in directions]:
        angle = np.arccos(sun @ axis / np.linalg.norm(axis))
        for limit in (0.5, 1.5, 2.5):
            seen, lost = (SunCondition(axis, limit, is_lost) for is_lost in (False, True))
            measurement = SimpleNamespace(sun_sensor=sun)
            assert (float(seen(measurement, 0.0)) > 0.0) == (angle < limit)
            assert (float(lost(measurement, 0.0)) > 0.0) == (angle > limit)
    dark, opposite = (SimpleNamespace(sun_sensor=each) for each in (np.zeros(3), -axis))
    assert float(SunCondition(axis)(dark, 0.0)) < 0.0
    assert float(SunCondition(axis, is_lost=True)(dark, 0.0)) > 0.0
    # by default any direction, also the opposite one
    opposite.sun_sensor = opposite.sun_sensor / np.linalg.norm(axis)
    assert float(SunCondition(axis)(opposite, 0.0)) > 0.0
