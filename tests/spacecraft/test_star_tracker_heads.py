"""Star tracker heads: blinding against geometry, noise against least squares, and the filter."""

import equinox as eqx
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gyrostat.control import OutputFeedback
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import error, from_rotation_vector, rotation_vector
from gyrostat.estimation import AttitudeFilter
from gyrostat.simulation import simulate
from gyrostat.spacecraft import (
    BodyMotion,
    Gyrostat,
    RateGyro,
    Spacecraft,
    SpacecraftSensor,
    TrackerGyroSensors,
    WheelTorqueCommand,
)
from gyrostat.spacecraft.orbit.earth import EARTH_RADIUS
from gyrostat.spacecraft.sensors.star_tracker_heads import StarTrackerHead, StarTrackerHeads
from gyrostat.wheel import WheelArray, orthogonal_axes
from tests.spacecraft import orbit_samples

DEGREE = np.pi / 180.0
REST = BodyMotion(jnp.array([1.0, 0.0, 0.0, 0.0]), jnp.zeros(3))
ACROSS, ABOUT = 2e-5, 2e-4
NORMAL = np.array([0.0, 1.0, 0.0])
"""Normal of the orbit: no blinding."""


@pytest.fixture(scope="module")
def orbit():
    """It starts between Earth and Sun, both along x; the orbit is in the x-z plane."""
    return orbit_samples.noon(6000.0)


sees_at = eqx.filter_jit(lambda head, motion, time: head.sees(motion, time))


def towards(angle):
    """Direction in the x-y plane, at an angle from the Sun, deg; the Earth is at 180."""
    return np.array([np.cos(angle * DEGREE), np.sin(angle * DEGREE), 0.0])


def test_a_head_is_blind_near_sun_and_earth_and_at_high_rate(orbit):
    limb = np.arcsin(EARTH_RADIUS / (EARTH_RADIUS + 500e3)) / DEGREE
    options = {"sun_exclusion": 40.0 * DEGREE, "earth_exclusion": 25.0 * DEGREE, "rate_limit": 0.02}

    def sees(angle, time=0.0, rate=(0.0, 0.0, 0.0)):
        head = StarTrackerHead(orbit, ACROSS, ABOUT, 3.0 * towards(angle), **options)
        head.check()
        return bool(sees_at(head, BodyMotion(REST.attitude, np.array(rate)), np.asarray(time)))

    assert [sees(angle) for angle in (0.0, 39.9, 40.1)] == [False, False, True]
    edge = 180.0 - limb - 25.0
    assert [sees(angle) for angle in (edge - 0.1, edge + 0.1, 180.0)] == [True, False, False]
    # behind the Earth the Sun does not blind, but the Earth does
    half = 0.5 * float(orbit.period)
    assert [sees(angle, half) for angle in (180.0, 180.0 - edge + 0.1, 0.0)] == [True, True, False]
    assert [sees(60.0, rate=(0.0, x, 0.0)) for x in (0.0199, 0.0201)] == [True, False]


def test_the_moon_blinds_a_head_unless_it_is_behind_the_earth(orbit):
    far, sun = 384400e3, np.array([0.0, -1.5e11, 0.0])  # the Sun is out of the way

    def sees(angle, behind, exclusion=10.0):
        # the orbit starts at +x; the Moon along y, or beyond the Earth along -x
        moon = far * (np.array([-1.0, 0.001, 0.0]) if behind else np.array([0.0, 1.0, 0.0]))
        circling = orbit_samples.environment(600.0, 20.0, sun=sun, moon=moon)
        start = np.asarray(circling.position(0.0))
        line = (moon - start) / np.linalg.norm(moon - start)
        axis = np.cross(line, [0.0, 0.0, 1.0])
        boresight = Rotation.from_rotvec(angle * DEGREE * axis / np.linalg.norm(axis)).apply(line)
        head = StarTrackerHead(
            circling, ACROSS, ABOUT, boresight, moon_exclusion=exclusion * DEGREE
        )
        head.check()
        blinding = head.blinding(REST, np.zeros(()))
        return bool(blinding.moon), bool(head.sees(REST, np.zeros(())))

    assert [sees(angle, behind=False)[0] for angle in (0.0, 9.99, 10.01)] == [True, True, False]
    assert sees(9.99, behind=False) == (True, False)
    assert sees(10.01, behind=False) == (False, True)
    assert not sees(0.0, behind=True)[0]
    with pytest.raises(InputError, match=r"angle: found 0\.1 rad and an orbit without"):
        StarTrackerHead(orbit, ACROSS, ABOUT, moon_exclusion=0.1).check()


def test_the_boresight_turns_with_the_body(orbit):
    head = StarTrackerHead(orbit, ACROSS, ABOUT, sun_exclusion=20.0 * DEGREE)
    for angle, seen in ((19.0, False), (21.0, True)):
        # body z to inertial x, then away from it
        turn = Rotation.from_euler("yz", [90.0, angle], degrees=True)
        attitude = jnp.asarray(turn.as_quat(scalar_first=True))
        assert bool(sees_at(head, BodyMotion(attitude, np.zeros(3)), np.zeros(()))) is seen


def samples(tracker, count=3000):
    keys = jax.random.split(jax.random.key(5), count)

    @jax.jit
    @jax.vmap
    def draw(key):
        attitude, sees, _ = tracker(REST, tracker.start(), jnp.zeros(()), 1.0, key)
        return rotation_vector(attitude), sees

    turn, sees = draw(keys)
    return np.asarray(turn), np.asarray(sees)


def covariance(axis):
    along = np.outer(axis, axis)
    return ACROSS**2 * (np.eye(3) - along) + ABOUT**2 * along


def test_two_heads_are_combined_by_least_squares(orbit):
    first, second = towards(70.0), np.array([0.0, 0.0, 1.0])
    offset = np.array([1e-4, 0.0, -2e-4])
    heads = tuple(
        StarTrackerHead(orbit, ACROSS, ABOUT, axis, misalignment=offset) for axis in (first, second)
    )
    error, sees = samples(StarTrackerHeads(heads))
    assert np.all(sees)
    expected = np.linalg.inv(sum(np.linalg.inv(covariance(axis)) for axis in (first, second)))
    np.testing.assert_allclose(error.mean(0), offset, atol=4e-6)
    np.testing.assert_allclose(np.cov(error.T), expected, atol=0.08 * expected.max())
    # one head alone, the other one blind
    blind = StarTrackerHead(orbit, ACROSS, ABOUT, towards(0.0), sun_exclusion=0.5)
    error, sees = samples(StarTrackerHeads((blind, heads[1])))
    np.testing.assert_array_equal(sees.any(0), [False, True])
    alone = covariance(second)
    np.testing.assert_allclose(np.cov(error.T), alone, atol=0.08 * alone.max())


def errors(tracker, rate, period, count):
    """Rotation vectors from the true to the measured attitude of a body that turns, (count, 3)."""

    @jax.jit
    def run(keys):
        def one(memory, step):
            number, key = step
            attitude = from_rotation_vector(number * period * jnp.asarray(rate))
            motion = BodyMotion(attitude, jnp.asarray(rate))
            measured, _, memory = tracker(motion, memory, number, period, key)
            return memory, rotation_vector(error(measured, attitude))

        return jax.lax.scan(one, tracker.start(), (jnp.arange(float(count)), keys))[1]

    return np.asarray(run(jax.random.split(jax.random.key(8), count)))


def test_noise_has_doubled_at_the_doubling_rate_and_the_delay_turns_back(orbit):
    axis, rate = np.array([0.0, 0.0, 1.0]), np.array([0.0, 3e-3, 4e-3])
    head = StarTrackerHead(orbit, ACROSS, ABOUT, axis, doubling_rate=5e-3, delay=0.2)
    found = errors(StarTrackerHeads((head,)), rate, 0.5, 3000)
    np.testing.assert_allclose(found.mean(0), -0.2 * rate, atol=2e-5)
    np.testing.assert_allclose(np.cov(found.T), 4.0 * covariance(axis), atol=0.1 * 4.0 * ABOUT**2)
    # the attitude at the time tag less the delay
    (before, now) = (Rotation.from_rotvec(time * rate) for time in (9.8, 10.0))
    np.testing.assert_allclose((now.inv() * before).as_rotvec(), -0.2 * rate, rtol=1e-9)


def test_orbit_error_has_the_period_of_the_orbit(orbit):
    head = StarTrackerHead(
        orbit, 1e-12, 1e-12, NORMAL, orbit_error=np.array([0.0, 2e-4, -1e-4]), orbit_phase=0.5
    )
    found = errors(StarTrackerHeads((head,)), np.zeros(3), float(orbit.period) / 8.0, 9)
    phase = 0.5 + 2.0 * np.pi * np.arange(9) / 8.0
    np.testing.assert_allclose(found, np.outer(np.sin(phase), [0.0, 2e-4, -1e-4]), atol=1e-10)


def test_field_error_is_correlated_over_the_angle_that_the_body_turns(orbit):
    """0.1 deg between samples: the correlation of neighbours is exp(-0.1 / 0.4)."""
    head = StarTrackerHead(orbit, 1e-9, 5e-9, NORMAL, field_error=3e-5, field_length=0.4 * DEGREE)
    found = errors(StarTrackerHeads((head,)), 0.1 * DEGREE * NORMAL, 1.0, 20_000)
    np.testing.assert_allclose(found.std(0), [3e-5, 15e-5, 3e-5], rtol=0.06)
    kept = [np.corrcoef(each[1:], each[:-1])[0, 1] for each in found.T]
    np.testing.assert_allclose(kept, np.exp(-0.25), atol=0.03)
    still = errors(StarTrackerHeads((head,)), np.zeros(3), 1.0, 50)
    assert np.max(np.ptp(still, axis=0)) < 1e-7
    assert np.max(np.abs(still)) > 1e-5


class Hold:
    """Wheels without torque."""

    def start(self, period):
        return ()

    def __call__(self, memory, measurement):
        return memory, WheelTorqueCommand(jnp.zeros(3))


def test_the_filter_continues_on_the_gyro_while_all_heads_are_blind(orbit, frictionless):
    """A body that turns about y at 1 deg/s: its head passes the Sun and the Earth."""
    craft = Spacecraft(np.diag([0.2, 0.2, 0.1]), WheelArray(orthogonal_axes(), np.full(3, 1e-30)))
    plant = Gyrostat(craft)
    head = StarTrackerHead(
        orbit, ACROSS, ABOUT, sun_exclusion=40.0 * DEGREE, earth_exclusion=20.0 * DEGREE
    )
    sensors = TrackerGyroSensors(
        SpacecraftSensor(plant), StarTrackerHeads((head,), 2), RateGyro(1e-5, 1e-7)
    )
    sensors.check()
    found = simulate(
        frictionless(plant),
        OutputFeedback(AttitudeFilter(ABOUT, 1e-5, 1e-7, 1e-4), Hold()),
        sensors,
        start=plant.start(
            attitude=from_rotation_vector(jnp.array([0.0, -0.2, 0.0])), rate=(0.0, DEGREE, 0.0)
        ),
        duration=360.0,
        control_period=1.0,
        engine="auto",
    )
    measured, seen = found.attitude_measured.values, found.tracker_heads.values
    np.testing.assert_array_equal(measured, seen[:, 0])
    assert not measured[1::2].any()
    # angle of body z from inertial x, the Sun; the Earth's centre is opposite to it
    angle = np.abs((90.0 + 0.2 / DEGREE - found.time.values + 180.0) % 360.0 - 180.0)
    limb = np.arcsin(EARTH_RADIUS / (EARTH_RADIUS + 500e3)) / DEGREE
    # the Earth's centre moves by the angle of the orbit
    clear = (angle > 40.0) & (angle < 180.0 - limb - 20.0)
    near = np.minimum(np.abs(angle - 40.0), np.abs(angle - 180.0 + limb + 20.0)) < 24.0
    sampled = np.arange(len(angle)) % 2 == 0
    np.testing.assert_array_equal((measured == clear)[sampled & ~near], True)
    assert 0.1 < measured.mean() < 0.4
    sigma = found.attitude_sigma.values
    assert np.all(found.surprise.values[~measured] == 0.0)
    blind = np.flatnonzero(~measured & (np.arange(len(measured)) > 60))
    assert sigma[blind].max() > 1.5 * sigma[measured].max()
    truth = jax.jit(jax.vmap(lambda a, b: rotation_vector(error(a, b))))(
        found.estimated_attitude.values, found.attitude.values
    )
    assert np.all(np.abs(np.asarray(truth))[10:] < 5.0 * sigma[10:])


def test_bad_heads_are_refused(orbit):
    for options, message in (
        ({"boresight": np.zeros(3)}, "boresight of a star tracker: found no direction"),
        ({"sun_exclusion": -0.1}, "sun exclusion angle: found -0.1"),
        ({"rate_limit": 0.0}, "star tracker rate limit: found 0"),
    ):
        with pytest.raises(InputError, match=message):
            StarTrackerHeads((StarTrackerHead(orbit, ACROSS, ABOUT, **options),)).check()
    with pytest.raises(InputError, match=r"star tracker periods: found 0\.5"):
        StarTrackerHeads((StarTrackerHead(orbit, ACROSS, ABOUT),), 0.5).check()
