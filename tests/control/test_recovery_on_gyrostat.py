"""Recovery on the full gyrostat: a wheel seizes, the others have friction."""

import numpy as np
from scipy.spatial.transform import Rotation

from gyrostat.control import MomentumRecovery
from gyrostat.core.jax64 import jnp
from gyrostat.papers.carvalho_fenili.reduced_gyrostat import (
    ReducedGyrostat,
    ReducedSensor,
    ReducedState,
)
from gyrostat.simulation import simulate
from gyrostat.spacecraft import Gyrostat, Spacecraft, SpacecraftSensor, WheelFailures
from gyrostat.wheel import WheelArray
from gyrostat.wheel.friction import ViscousCoulomb

ROTORS, HELD = 0.006, np.array([0.6, 0.8, 0.4])
WORKS = np.array([True, True, False])


def craft(viscous, coulomb):
    friction = ViscousCoulomb(viscous=jnp.full(3, viscous), coulomb=jnp.full(3, coulomb))
    ones = jnp.ones(3)
    wheels = WheelArray(jnp.eye(3), ROTORS * ones, 0.1 * ones, 3.0 * ones, friction)
    return Spacecraft(jnp.diag(jnp.array([16.0, 12.0, 8.0])), wheels)


def settled(run, target):
    """From when the pointing error stays below 0.05 deg, s."""
    turns = Rotation.from_quat(np.roll(run.attitude.values, -1, axis=1)) * target.inv()
    out = np.flatnonzero(turns.magnitude() > np.radians(0.05))
    assert len(out)
    assert out[-1] + 1 < len(run.time)
    return float(run.time[out[-1] + 1])


def test_settles_as_the_reduced_one_and_holds_against_friction():
    times = []
    for viscous, coulomb in ((0.0, 0.0), (5e-6, 1e-3)):
        body = craft(viscous, coulomb)
        full = Gyrostat(body, failures=WheelFailures.none(3).seizes(2, 0.0))
        start = full.start(attitude=(1.0, 0.2, -0.3, 0.5), wheel_speed=HELD / ROTORS)
        total = np.array(start.momentum)
        wanted = np.linalg.norm(total) * np.array([-0.6, 0.8, 0.0])
        goal = Rotation.random(rng=3)
        goal = goal * Rotation.align_vectors(goal.inv().apply(total)[None], wanted[None])[0]
        controller = MomentumRecovery.plan(
            body,
            WORKS,
            total_momentum=total,
            target=np.roll(goal.as_quat(), 1),
            seized=~WORKS,
        )
        run = simulate(
            full,
            controller,
            SpacecraftSensor(full),
            start=start,
            duration=250.0,
            control_period=0.5,
        )
        times.append(settled(run, goal))
        assert np.abs(run.rate.values[-1]).max() < 1e-6
        np.testing.assert_allclose(
            run.momentum.values - total, 0.0, atol=1e-8 * np.linalg.norm(total)
        )
    # the seized rotor turns with the body, and gave it all that it had
    locked = body.inertia + ROTORS * np.diag([0.0, 0.0, 1.0])
    reduced = ReducedGyrostat(
        Spacecraft(locked, body.wheels), jnp.asarray(WORKS), jnp.asarray(total)
    )
    state = ReducedState(start.attitude, jnp.asarray(HELD * WORKS))
    run = simulate(
        reduced,
        controller,
        ReducedSensor(reduced),
        start=state,
        duration=250.0,
        control_period=0.5,
    )
    times.append(settled(run, goal))
    assert abs(times[0] - times[2]) <= 0.5
    assert times[1] <= 100.0 + 15.0 * 16.0 / np.linalg.norm(total)
