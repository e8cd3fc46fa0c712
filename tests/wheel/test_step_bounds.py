"""What is seen at the start of a segment, against what is then found by looking closely."""

import equinox as eqx
import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft import Gyrostat, Spacecraft
from gyrostat.spacecraft.wheels_on_body import Carrier, WheelsOnBody
from gyrostat.wheel import (
    Motion,
    WheelArray,
    coupled_wheels,
    pyramid_axes,
    step_bounds,
    step_coupled_wheels,
)
from gyrostat.wheel.friction import Stribeck

WHEELS = 4
RANDOM = np.random.default_rng(4)
FRICTION = Stribeck(viscous=5e-6, coulomb=9e-4, static=1.1e-3, stribeck_speed=0.5)
BODY = Spacecraft(
    np.array([[0.9, 0.02, -0.03], [0.02, 0.8, 0.01], [-0.03, 0.01, 0.7]]),
    WheelArray(axes=pyramid_axes(), inertia=1e-3 * np.ones(4), friction=FRICTION),
)


class Swing(eqx.Module):
    """An external torque that changes with attitude and time."""

    def __call__(self, spacecraft, attitude, time):
        return 1e-3 * attitude[1:] * jnp.sin(3.0 * time) + 2e-4 * time


def contacts(torque, drag=0.0):
    plant = Gyrostat(BODY, environment=(Swing(),))
    inverse = inverse_definite(jnp.asarray(BODY.inertia))
    axes = jnp.asarray(BODY.wheels.axes)
    return WheelsOnBody(
        friction=FRICTION,
        body=plant,
        torque=jnp.asarray(torque),
        seized=jnp.zeros(WHEELS, bool),
        added_viscous=drag * jnp.ones(WHEELS),
        started=jnp.array(2.0),
        mobility=jnp.diag(1.0 / BODY.wheels.inertia) + axes.T @ inverse @ axes,
        inverse=inverse,
        inverse_locked=inverse_definite(BODY.inertia_locked()),
    )


def moving(speed, rate):
    plant = Gyrostat(BODY)
    state = plant.start(attitude=(0.8, 0.36, -0.48, 0.0), rate=rate, wheel_speed=speed)
    return Motion(state.wheel_speed, Carrier(state.attitude, state.momentum))


def drawn(count, torque, rate):
    """Motor torques, wheel speeds, rates and durations of all sizes."""
    speeds = [0.0, 0.0, 0.01, -0.2, 0.5, -3.0, 4.0, 60.0]
    return (
        RANDOM.uniform(-torque, torque, (count, WHEELS)),
        RANDOM.choice(speeds, (count, WHEELS)),
        RANDOM.uniform(-rate, rate, (count, 3)),
        10.0 ** RANDOM.uniform(-3.0, 0.0, count),
    )


def test_changes_are_the_derivatives_along_the_motion():
    @jax.jit
    def both(torque, speed):
        contact, motion = contacts(torque, drag=2e-5), moving(speed, (0.1, -0.2, 0.15))
        modes = contact.modes(jnp.sign(motion.speed))
        rate = contact.rate(motion, modes, 0.3)
        drive, drift = jax.jvp(contact.drive, (motion, 0.3), (rate, 1.0))[1]
        turn = jax.jvp(lambda motion: contact.rate_of_body(motion)[0], (motion,), (rate,))[1]
        derivatives = drive, contact.mobility @ drive + drift, turn @ turn
        return contact.changes(motion, rate, 0.3), derivatives

    changes, (drive, pull, turn) = both(
        RANDOM.normal(0.0, 1e-3, WHEELS), RANDOM.normal(0.0, 20.0, WHEELS)
    )
    np.testing.assert_allclose(changes.drive, drive, rtol=1e-12)
    np.testing.assert_allclose(changes.pull, pull, rtol=1e-11, atol=1e-14)
    np.testing.assert_allclose(changes.turn_change_squared, turn, rtol=1e-11)


def test_a_segment_taken_whole_is_within_its_limit(monkeypatch):
    is_resolved = step_bounds.is_resolved

    def limits(seen, torque, speed, rate, remaining):
        monkeypatch.setattr(step_bounds, "is_resolved", lambda *given: is_resolved(*given) & seen)
        contact, motion = contacts(torque), moving(speed, rate)
        modes = coupled_wheels._modes(contact, motion, jnp.zeros(WHEELS), 0.0)
        torque = contact.torques(motion, modes, 0.0)
        rate = contact.rate_under(motion, torque, modes, 0.0)
        known = (contact, motion, modes, 0.0, torque, rate, remaining)
        return step_bounds.step_bounds.__wrapped__(*known)[1], modes.direction

    given = drawn(400, 0.02, 0.3)
    both = jax.jit(jax.vmap(limits, (None, 0, 0, 0, 0)))  # compiled once for both
    (quick, direction), (exact, _) = (both(np.array(seen), *given) for seen in (True, False))
    turns = np.any(np.asarray(direction) != 0.0, axis=1)
    np.testing.assert_allclose(quick[turns], np.minimum(exact, given[3])[turns], rtol=1e-12)
    assert 0.2 < np.mean(quick == given[3]) < 0.9


def test_what_rests_on_would_have_been_found_at_rest(monkeypatch):
    stays = coupled_wheels.stays

    def carried(seen, torque, speed, rate, duration):
        monkeypatch.setattr(coupled_wheels, "stays", lambda *given: stays(*given) & seen)
        return step_coupled_wheels(contacts(torque), moving(speed, rate), duration)

    given = drawn(400, 3e-3, 0.02)

    @jax.jit  # compiled once for both, and not for a batch
    def both(seen, *given):
        return jax.lax.map(lambda one: carried(seen, *one), given)

    (quick, resolved), (close, _) = (both(np.array(seen), *given) for seen in (True, False))
    for one, other in zip(jax.tree.leaves(quick), jax.tree.leaves(close), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15)
    quick, close = np.asarray(quick.speed), np.asarray(close.speed)
    held = given[1] == 0.0
    np.testing.assert_array_equal(quick == 0.0, close == 0.0)
    assert np.all(resolved)
    assert 0.1 < np.mean(quick[held] == 0.0) < 0.9
