"""Pointing with two wheels on the honest plant: where it arrives, what it asks of the wheels."""

import equinox as eqx
import numpy as np
import pytest

from gyrostat.control import BoresightLaw, FirstOrderLags, SafeFrit, TwoWheelPointing, WheelMap
from gyrostat.control.underactuated.boresight import governed
from gyrostat.control.underactuated.two_wheel_law import largest_inertia
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.simulation import simulate, stack
from gyrostat.spacecraft import (
    Gyrostat,
    SinusoidalMomentum,
    Spacecraft,
    SpacecraftSensor,
    SpeedLoopSpacecraft,
)
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

INERTIA = np.array([[400.0, 6.0, -4.0], [6.0, 500.0, 5.0], [-4.0, 5.0, 600.0]])
PRINCIPAL = np.diag([400.0, 500.0, 600.0])
ROTOR, LIMIT, TOP = 0.45, 0.1, 12.0
MAP_LIMITS = (jnp.full(2, 0.2), jnp.full(2, 20.0))


def spacecraft(inertia=INERTIA, tilt=0.0, coulomb=0.0, axes=None, rotors=1.0):
    if axes is None:
        axes = np.array([[np.cos(tilt), 0.0, np.sin(tilt)], [0.0, 1.0, 0.0]]).T
    wheels = WheelArray(
        axes=jnp.asarray(axes),
        inertia=jnp.full(axes.shape[1], ROTOR) * rotors,
        torque_limit=jnp.full(axes.shape[1], LIMIT),
        momentum_limit=jnp.full(axes.shape[1], ROTOR * TOP) * rotors,
        friction=ViscousCoulomb(
            viscous=jnp.zeros(axes.shape[1]), coulomb=jnp.full(axes.shape[1], coulomb)
        ),
    )
    return Spacecraft(inertia=jnp.asarray(inertia), wheels=wheels)


def tuner(**changes):
    fields = {
        "feedback": jnp.full(2, 0.1),
        "reference": FirstOrderLags(jnp.full(2, 0.1)),
        "forgetting": 0.995,
        "smoothing": 0.1,
        "dead_zone": jnp.full(2, 1e-6),
        "initial_gain": jnp.full(2, 0.05),
        "lowest": jnp.full(2, 0.02),
        "highest": jnp.full(2, 0.2),
        "largest_covariance": 1e12,
    }
    return SafeFrit(**{**fields, **changes})


def turned(angle, azimuth):
    """Body z off inertial z by an angle about a body axis across it."""
    return np.array(
        [
            np.cos(0.5 * angle),
            *(np.sin(0.5 * angle) * np.array([np.cos(azimuth), np.sin(azimuth), 0.0])),
        ]
    )


ANGLES = np.deg2rad([0.0, 3.0, 40.0, 90.0, 150.0, 179.95, 180.0])


@pytest.fixture(scope="module")
def flights():
    """Every angle once, noise, bias, wrong inertia, axes and rotors, wheels at speed."""
    random = np.random.default_rng(7)
    plants, starts, sensors = [], [], []
    for angle in ANGLES:
        factor = np.diag(1.0 + random.uniform(-0.025, 0.025, 3))
        rotors = random.choice([0.95, 1.05], 2)
        body = spacecraft(factor @ INERTIA @ factor, tilt=0.008, coulomb=0.9e-3, rotors=rotors)
        momentum = SinusoidalMomentum(
            jnp.asarray(random.uniform(-0.02, 0.02, 3)), 1e-3, jnp.asarray(random.uniform(0, 6, 3))
        )
        plants.append(SpeedLoopSpacecraft(body, momentum))
        starts.append(
            plants[-1].start(
                attitude=turned(angle, random.uniform(0.0, 6.0)), wheel_speed=[-0.5, 0.5]
            )
        )
        bias = jnp.asarray(random.uniform(-5e-6, 5e-6, 3))
        sensors.append(SpacecraftSensor(Gyrostat(body), 5e-5, 5e-6, 9e-4, bias))
    return simulate(
        stack(plants),
        TwoWheelPointing(spacecraft(), tuner=tuner()),
        stack(sensors),
        start=stack(starts),
        duration=700.0,
        control_period=0.1,
        runs=len(ANGLES),
        seed=3,
    )


def errors(flights):
    q = flights.attitude.values
    x, y = (
        2.0 * (q[..., 1] * q[..., 3] + q[..., 0] * q[..., 2]),
        2.0 * (q[..., 2] * q[..., 3] - q[..., 0] * q[..., 1]),
    )
    return np.rad2deg(np.arctan2(np.hypot(x, y), 1.0 - 2.0 * (q[..., 1] ** 2 + q[..., 2] ** 2)))


def test_it_arrives_from_every_angle_and_half_a_turn(flights):
    assert np.all(flights.status == 0)
    error = errors(flights)
    assert np.allclose(error[:, 0], np.rad2deg(ANGLES), atol=1e-6)
    assert np.all(error[:, -2000:] < 0.01)


def test_wheels_are_asked_for_no_more_than_they_have(flights):
    assert np.max(np.abs(flights.torque_demand)) < LIMIT
    assert np.max(np.abs(flights.wheel_speed)) < TOP
    # and that is no slack: the governor cuts, to what it is told
    steps = np.abs(np.diff(flights.speed.values, axis=1))
    assert np.max(steps) == pytest.approx(0.93 * LIMIT / ROTOR * 0.1, rel=1e-9)
    assert np.min(flights.share) < 0.1
    # the largest turns meet the limit of speed
    assert np.max(np.abs(flights.wheel_speed)) > 0.9 * TOP


def test_way_there_takes_about_the_time_that_the_torque_allows(flights):
    error = errors(flights)[2]
    settled = 0.1 * (1 + np.max(np.flatnonzero(error > 0.05)))
    # between both wheels' torque about their own axes, with braking, and one's about the other
    quickest = 2.0 * np.sqrt(ANGLES[2] * 400.0 / LIMIT / np.sqrt(2.0))
    slowest = 2.0 * np.sqrt(ANGLES[2] * 550.0 / LIMIT) + 40.0
    assert quickest < settled < slowest


def test_gain_stays_in_range_and_waits_while_the_wheels_are_at_their_limit(flights):
    gain = flights.compensator_gain.values
    assert np.all((gain >= 0.02) & (gain <= 0.2))
    cut = flights.share.values < 1.0
    assert np.all(gain[:, :500][np.logical_or.accumulate(cut[:, :500], axis=1)] == 0.05)
    assert np.ptp(gain[:, -1]) > 0.0


def test_wheel_map_is_the_motion_of_the_gyrostat():
    body = Gyrostat(spacecraft(tilt=0.1))
    state = body.start(attitude=turned(1.0, 0.4), rate=(0.01, -0.02, 0.03), wheel_speed=(3.0, -2.0))
    map = WheelMap.of(body.spacecraft)
    momentum = jnp.asarray(INERTIA + (body.spacecraft.inertia_locked() - INERTIA)) @ jnp.array(
        [0.01, -0.02, 0.03]
    ) + body.spacecraft.wheels.axes @ (ROTOR * state.wheel_speed)
    assert np.allclose(map.rate(momentum, state.wheel_speed), [0.01, -0.02], atol=1e-15)
    assert np.allclose(map.speed(momentum, jnp.array([0.01, -0.02])), [3.0, -2.0], atol=1e-12)


@pytest.fixture(scope="module")
def profile():
    map = WheelMap.of(spacecraft(PRINCIPAL))
    law = BoresightLaw(gain=0.1, braking=0.9)

    def rates(direction, resting):
        return law(direction, resting, map, MAP_LIMITS)

    return jax.jit(jax.vmap(rates, in_axes=(0, None)))


def test_profile_is_smooth_brakes_as_said_and_keeps_to_the_speed(profile):
    angle = np.linspace(1e-7, np.pi - 1e-7, 20_001)
    towards = np.stack([np.sin(angle), 0.0 * angle, np.cos(angle)], axis=1)
    rate = np.asarray(profile(towards, jnp.zeros(2)))
    # z x (x sin + z cos) = y sin
    assert np.all(rate[:, 0] == 0.0)
    speed = rate[:, 1]
    braking = 0.9 * 0.2 * ROTOR / (500.0 + ROTOR)
    top = 0.97 * 20.0 * ROTOR / (500.0 + ROTOR)
    knee, near = braking / 0.1**2, angle < 0.9 * braking / 0.1**2
    assert np.allclose(speed[near], 0.1 * angle[near], rtol=1e-9)
    far = (angle > 1.1 * knee) & (speed < 0.999 * top)
    slope = np.gradient(speed, angle)
    assert np.allclose((speed * slope)[far][2:-2], braking, rtol=1e-3)
    assert np.max(speed) == pytest.approx(top, rel=1e-12)
    assert np.max(np.abs(np.diff(slope[angle < 0.5]))) < 0.01
    slower = profile(towards[-1:], jnp.array([0.0, 5.0]))
    assert slower[0, 1] == pytest.approx((0.97 * 20.0 - 5.0) * ROTOR / (500.0 + ROTOR), rel=1e-9)
    # no way is the shorter one at half a turn: about x
    assert np.all(np.asarray(profile(jnp.array([[0.0, 0.0, -1.0]]), jnp.zeros(2)))[0, 0] > 0.0)
    assert np.all(np.asarray(profile(jnp.array([[0.0, 0.0, 1.0]]), jnp.zeros(2))) == 0.0)


def test_governor_keeps_the_direction():
    before, wanted = jnp.array([1.0, -1.0]), jnp.array([3.0, -2.0])
    found, share = governed(before, wanted, jnp.array([0.5, 0.1]))
    assert share == pytest.approx(0.1)
    assert np.allclose(found, [1.2, -1.1])
    assert governed(before, wanted, jnp.array([5.0, 5.0]))[1] == 1.0
    assert np.array_equal(governed(before, before, jnp.array([1.0, 1.0]))[0], before)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"spacecraft": spacecraft(axes=np.array([[1.0, 0, 0], [1.0, 0, 0]]).T)}, "parallel"),
        ({"spacecraft": spacecraft(axes=np.eye(3))}, "3 wheels"),
        (
            {"spacecraft": spacecraft(np.diag([400.0, 500.0, 600.0]), axes=np.eye(3)[:, [0, 2]])},
            "one axis only",
        ),
        ({"gain": np.array([-0.1, 0.1])}, "compensator gain"),
        ({"momentum_time": 0.0}, "momentum time"),
        ({"rotor_sigma": 0.0}, "rotor sigma"),
        ({"torque_share": 0.0}, "torque share"),
        ({"torque_share": 1.2}, "torque share"),
        ({"law": BoresightLaw(gain=0.0)}, "boresight gain"),
        ({"law": BoresightLaw(braking=1.5)}, "braking"),
        ({"law": BoresightLaw(top_share=np.nan)}, "top_share"),
        ({"tuner": tuner(forgetting=1.5)}, "forgetting"),
    ],
)
def test_bad_parameters_are_refused(change, words):
    with pytest.raises(InputError, match=words):
        TwoWheelPointing(**{"spacecraft": spacecraft(), **change}).check()


def test_wheels_without_a_torque_limit_are_refused():
    wheels = eqx.tree_at(lambda w: w.torque_limit, spacecraft().wheels, jnp.full(2, jnp.inf))
    with pytest.raises(InputError, match="torque limit"):
        TwoWheelPointing(Spacecraft(jnp.asarray(INERTIA), wheels)).check()


def test_gains_beyond_two_over_the_period_are_refused():
    with pytest.raises(InputError, match="below 20 1/s"):
        TwoWheelPointing(spacecraft(), gain=np.full(2, 20.0)).check_period(0.1)
    with pytest.raises(InputError, match="it would diverge"):
        TwoWheelPointing(spacecraft(), tuner=tuner(highest=jnp.full(2, 25.0))).check_period(0.1)
    TwoWheelPointing(spacecraft(), gain=np.full(2, 19.9)).check_period(0.1)


def test_a_bias_is_added_to_the_rate_and_refused_where_it_is_none():
    body = Gyrostat(spacecraft())
    state, bias = body.start(rate=(0.01, 0.0, 0.0)), np.array([1e-3, -2e-3, 3e-3])
    sensor = SpacecraftSensor(body, rate_bias=jnp.asarray(bias))
    _, seen = sensor(sensor.start(state, 0.1), state, jax.random.key(0))
    assert np.allclose(seen.rate, [0.011, -2e-3, 3e-3], atol=1e-15)
    with pytest.raises(InputError, match="rate bias"):
        SpacecraftSensor(body, rate_bias=np.nan).check()


def test_the_largest_inertia_bounds_the_principal_ones():
    """Gershgorin's bound, which a diagonal tensor attains."""
    random = np.random.default_rng(3)
    assert float(largest_inertia(jnp.diag(jnp.array([2.0, 5.0, 3.0])))) == 5.0
    for _ in range(50):
        axes = np.linalg.qr(random.standard_normal((3, 3)))[0]
        inertia = axes @ np.diag(random.uniform(1.0, 4.0, 3)) @ axes.T
        bound = float(largest_inertia(jnp.asarray(inertia)))
        assert np.linalg.eigvalsh(inertia)[-1] <= bound <= 3.0 * np.linalg.eigvalsh(inertia)[-1]
