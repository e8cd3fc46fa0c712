"""Motion of fleets: against the simulation of the same spacecraft, and conservation of momentum."""

from dataclasses import replace
from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
import pytest
import scipy.linalg

from gyrostat.codegen.simd import compiler
from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import conjugate, product, to_body
from gyrostat.monitoring.fleet.attitude_loop import attitude_loop
from gyrostat.monitoring.fleet.faults.coulomb_growth import CoulombGrowth
from gyrostat.monitoring.fleet.faults.seizure import Seizure
from gyrostat.monitoring.fleet.faults.torque_bursts import TorqueBursts
from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.pointing import CROSSINGS, HIGH, LOW, SLEWS, motion
from gyrostat.monitoring.fleet.vehicle import LARGE, SMALL
from gyrostat.simulation import simulate
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.spacecraft.friction_steps import FrictionSteps
from gyrostat.spacecraft.gyrostat_state import WheelTorqueCommand
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction.stribeck import Stribeck

pytestmark = pytest.mark.optimised
DURATION = 1800
STEP_DAY = 1200.0 / 86400.0


class FullState(NamedTuple):
    """What the controller of the reference knows."""

    attitude: Any
    rate: Any
    wheel_speed: Any
    momentum: Any


class FullSensor(eqx.Module):
    """Everything, without noise."""

    plant: Gyrostat

    def start(self, state, period):
        """No memory."""
        return ()

    def __call__(self, memory, state, key):
        """State as it is."""
        rate = self.plant.rate(state)
        return memory, FullState(state.attitude, rate, state.wheel_speed, state.momentum)


class Pointed(eqx.Module):
    """The attitude loop of a fleet, with exact rotations."""

    quaternion: Any
    rate: Any
    acceleration: Any
    inertia: Any
    gains: Any
    spread: Any
    null: Any
    rotor: float
    target: float
    null_time: float

    def start(self, period):
        """Number of the sample."""
        return jnp.asarray(0)

    def __call__(self, memory, measured):
        """Torque command."""
        q, rate, acceleration = (
            each[memory] for each in (self.quaternion, self.rate, self.acceleration)
        )
        error = product(conjugate(q), measured.attitude)
        error = error * jnp.sign(error[0])
        momentum = to_body(measured.attitude, measured.momentum)
        rate_error = measured.rate - to_body(error, rate)
        body = (
            self.inertia * acceleration
            + jnp.cross(rate, momentum)
            - self.gains[0] * 2.0 * error[1:]
            - self.gains[1] * rate_error
        )
        null = self.rotor * self.null @ measured.wheel_speed
        torque = -self.spread @ body - self.null * (null - self.target) / self.null_time
        return memory + 1, WheelTorqueCommand(torque)


def quiet(vehicle, **changes):
    """Vehicle without noise of sensors, and with friction that does not depend on temperature."""
    scatter = {"motor_scatter": 0.0, "offset_scatter": 0.0}
    wheel = replace(vehicle.wheel, viscous_temperature=0.0, coulomb_temperature=0.0, **scatter)
    silent = {"attitude_sigma": 0.0, "rate_sigma": 0.0}
    return replace(vehicle, wheel=wheel, **silent, **changes)


@pytest.fixture(scope="module")
def flown():
    """First half hour of a flight with slews, a crossing of zero and a step of the friction."""
    cell = Cell(quiet(SMALL), HIGH, CROSSINGS, noise_sigma=0.0, seed=SEED)
    flight = Flight(3, (CoulombGrowth(wheel=1, day=STEP_DAY, size=0.5),))
    return cell, flight, next(Fleet(cell, [flight]).days(1))[0]


SEED = 1


def simulated(cell, flight, first_speed):
    """The same flight by the library's simulation, 8 samples a second."""
    vehicle, truth = cell.vehicle, flight.wheels(cell)
    rotor = vehicle.wheel.inertia
    time = vehicle.control_period * np.arange(8 * DURATION + 1)
    path = motion(cell.orbit, cell.pointing, vehicle.slew_time, time, cell.seed)

    def friction(coulomb):
        return Stribeck(
            viscous=truth["viscous"],
            coulomb=coulomb,
            static=coulomb + truth["excess"],
            stribeck_speed=vehicle.wheel.stribeck_speed,
        )

    grown = truth["coulomb"] * np.array([1.0, 1.5, 1.0, 1.0])
    # a torque that does not depend on the sense is an external torque on body and wheel alike
    plant = Gyrostat(
        Spacecraft(
            np.diag(vehicle.inertia),
            WheelArray(vehicle.axes, np.full(4, rotor), friction=friction(truth["coulomb"])),
        ),
        external_torque=vehicle.constant_torque,
        friction_steps=FrictionSteps(
            np.array([np.inf, 86400.0 * STEP_DAY, np.inf, np.inf]), friction(grown)
        ),
    )
    loop = attitude_loop(vehicle, 1)
    controller = Pointed(
        *(jnp.asarray(x) for x in (path.quaternion, path.rate, path.acceleration)),
        jnp.asarray(vehicle.inertia),
        jnp.asarray(np.stack([loop.stiffness, loop.damping])),
        jnp.asarray(vehicle.spread),
        jnp.asarray(vehicle.null),
        rotor,
        2.0 * rotor * vehicle.bias_speed * cell.pointing.bias_share,
        vehicle.null_time,
    )
    start = plant.start(
        attitude=path.quaternion[0], rate=path.rate[0], wheel_speed=np.asarray(first_speed, float)
    )
    run = simulate(
        *(plant, controller, FullSensor(plant)),
        **{"start": start, "duration": DURATION, "control_period": 0.125, "engine": "auto"},
    )
    return run


def test_compressed_motion_equals_the_simulation(flown):
    cell, flight, day = flown
    run = simulated(cell, flight, day.speed[0])
    speed = run["wheel_speed"].values[::8][:DURATION]
    torque = run["torque"].values[::8][:DURATION]
    coulomb = cell.vehicle.wheel.coulomb
    assert np.min(np.abs(speed)) < 1e-3, "a wheel stops and crosses zero"
    slow = np.min(np.abs(speed), axis=1) < 1.0
    near = np.convolve(slow, np.ones(121), "same") > 0.0
    difference = np.abs(torque - day.torque[:DURATION])
    # in the minute about a crossing: times of sticking and breakaway are rounded to a step
    assert np.mean(difference[near]) < 0.03 * coulomb
    assert np.mean(~near) > 0.5
    assert np.quantile(difference[~near], 0.99) < 5e-4 * coulomb
    assert np.max(np.abs(speed - day.speed[:DURATION])[~near]) < 0.06


@pytest.mark.skipif(compiler() is None, reason="needs a C compiler")
def test_both_engines_fly_alike():
    # slews, thrusters, a seizure and bursts; JAX is what flies where there is no compiler
    faults = (TorqueBursts(wheel=0, day=0.1, size=0.5), Seizure(2, 0.5, 200.0, 0.2))
    flights = [Flight(1, faults), Flight(2)]
    cell = Cell(SMALL, HIGH, SLEWS)
    native, by_jax = (next(Fleet(cell, flights, name).days(1)) for name in ("native", "jax"))
    for one, other in zip(native, by_jax, strict=True):
        for name, scale in {"speed": 1.0, "torque": SMALL.wheel.coulomb, "angle": 1e-4}.items():
            assert np.max(np.abs(getattr(one, name) - getattr(other, name))) < 1e-3 * scale, name
        assert np.array_equal(one.firing, other.firing)


def test_total_momentum_is_conserved_with_noise_bursts_and_seizure():
    far = replace(HIGH, altitude=1e9)
    vehicle = quiet(LARGE, constant_torque=np.zeros(3))
    cell = Cell(vehicle, far, SLEWS, seed=2)
    faults = (
        TorqueBursts(wheel=0, day=0.1, size=0.5),
        Seizure(wheel=2, day=0.5, size=200.0, duration=0.2),
    )
    day = next(Fleet(cell, [Flight(1, faults)]).days(1))[0]
    path = day.commanded
    rate = path.rate - np.cross(day.angle, path.rate) + day.rate
    rotors = vehicle.wheel.inertia * (day.speed + rate @ vehicle.axes)
    momentum = vehicle.inertia * rate + rotors @ vehicle.axes.T
    # the fleet turns by angles of first order, H_body = (1 - [angle x]) H_reference
    tilt = np.eye(3) - np.cross(day.angle[:, None, :], np.eye(3)).transpose(0, 2, 1)
    turned = np.linalg.solve(tilt, momentum[..., None])[..., 0]
    inertial = np.einsum("nij,nj->ni", path.to_inertial, turned)
    wheels = vehicle.wheel.inertia * np.abs(day.speed).max()
    assert np.abs(day.speed[-1, 2]) < 1.0, "the wheel has stopped"
    assert np.max(np.abs(inertial - inertial[0])) < 2e-5 * wheels


def test_friction_noise_has_its_variance_and_correlation_time():
    cell = Cell(LARGE, LOW, SLEWS, noise_sigma=0.02, noise_time=1200.0)
    days = next(Fleet(cell, [Flight(k) for k in range(12)]).days(1))
    wheel = LARGE.wheel
    noise = np.concatenate([_noise(day, cell) for day in days], axis=1)
    samples = noise.shape[1] * 86400.0 / (2.0 * 1200.0)
    assert np.std(noise) == pytest.approx(0.02, rel=4.0 / np.sqrt(2.0 * samples))
    lagged = np.mean(noise[1200:] * noise[:-1200]) / np.mean(noise**2)
    assert lagged == pytest.approx(np.exp(-1.0), abs=4.0 / np.sqrt(samples))
    assert wheel.coulomb > 0.0


def _noise(day, cell):
    """Relative deviation of the realised Coulomb torque from its level."""
    minutes = day.time[::60]
    temperature = cell.orbit.temperature(minutes)
    level = np.stack(
        [row["coulomb"] for row in day.flight.slow(cell, minutes / 86400.0, temperature)], axis=1
    )
    return day.coulomb / np.repeat(level, 60, axis=0) - 1.0


@pytest.mark.parametrize("vehicle", [LARGE, SMALL])
def test_one_long_step_equals_short_steps(vehicle):
    one, eight = attitude_loop(vehicle, 1), attitude_loop(vehicle, 8)
    for axis in range(3):
        noise = np.hypot(
            one.stiffness[axis] * vehicle.attitude_sigma, one.damping[axis] * vehicle.rate_sigma
        )
        stationary = [
            scipy.linalg.solve_discrete_lyapunov(
                loop.transition[..., axis],
                loop.later_noise[..., axis] @ loop.later_noise[..., axis].T
                + noise**2 * np.outer(loop.first_noise[:, axis], loop.first_noise[:, axis]),
            )
            for loop in (one, eight)
        ]
        assert stationary[1] == pytest.approx(stationary[0], rel=1e-9)
        held = [
            np.linalg.solve(np.eye(2) - loop.transition[..., axis], loop.disturbance[:, axis])
            for loop in (one, eight)
        ]
        assert held[0][0] == pytest.approx(1.0 / one.stiffness[axis], rel=1e-12)
        assert held[1][0] == pytest.approx(held[0][0], rel=1e-9)


def test_friction_noise_shows_in_current_and_speed():
    # of two flights that differ in noise alone, current and speed differ; total momentum does not
    cell = Cell(quiet(LARGE), LOW, SLEWS, noise_sigma=0.02)
    days = [
        next(Fleet(each, [Flight(5)]).days(1))[0] for each in (cell, replace(cell, noise_sigma=0.0))
    ]
    torque, speed = (getattr(days[0], k) - getattr(days[1], k) for k in ("torque", "speed"))
    deviation = days[0].coulomb - days[1].coulomb
    sense = np.sign(days[0].speed)
    covariance = np.mean(torque * sense * deviation, axis=0) / np.mean(deviation**2, axis=0)
    # the body axes see three quarters of each wheel's friction, the null-space loop the last one
    assert covariance == pytest.approx(np.ones(4), abs=0.15)
    assert np.all(np.std(speed, axis=0) > 1e-3)
