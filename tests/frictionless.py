"""Wheels without friction on a rigid body, for tests that need a plant that compiles soon."""

import equinox as eqx

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import normalised, rate_of_quaternion, to_body, to_inertial
from gyrostat.spacecraft import Gyrostat, GyrostatState
from gyrostat.spacecraft.torque_models import commanded_torques


class Frictionless(eqx.Module):
    """Wheels without friction or limits on a body: one Runge-Kutta step, which compiles soon."""

    gyrostat: Gyrostat

    @property
    def spacecraft(self):
        return self.gyrostat.spacecraft

    def start(self, **motion):
        return self.gyrostat.start(**motion)

    def rate(self, state):
        return self.gyrostat.rate(state)

    @property
    def modes(self):
        return self.gyrostat.modes

    def __call__(self, state, command, time, duration):
        """dq/dt, dH/dt and dw/dt."""
        craft, wheels = self.gyrostat.spacecraft, self.gyrostat.spacecraft.wheels
        given = commanded_torques(self.gyrostat.actuators, command, None, time)

        def slope(state, now):
            rate, attitude = self.gyrostat.rate(state), state.attitude
            torque = self.gyrostat.torque(attitude, now)
            for part in given:
                torque = torque + part(craft, attitude, now)
            turning = jnp.cross(rate, to_body(attitude, state.momentum))
            inverse = inverse_definite(jnp.asarray(craft.inertia))
            turn = inverse @ (torque - turning - wheels.axes @ command.torque)
            speed = command.torque / wheels.inertia - wheels.axes.T @ turn
            gained = to_inertial(attitude, torque)
            return GyrostatState(rate_of_quaternion(attitude, rate), gained, speed)

        def stage(carry, share):
            total, rate = carry
            reach, weight = share
            there = jax.tree.map(lambda y, k: y + reach * duration * k, state, rate)
            rate = slope(there, time + reach * duration)
            return (jax.tree.map(lambda y, k: y + weight * duration * k, total, rate), rate), None

        shares = (jnp.array([0.0, 0.5, 0.5, 1.0]), jnp.array([1.0, 2.0, 2.0, 1.0]) / 6.0)
        nothing = jax.tree.map(jnp.zeros_like, state)
        after = jax.lax.scan(stage, (state, nothing), shares)[0][0]
        return after._replace(attitude=normalised(after.attitude)), jnp.array(True)

    def diverged(self, state):
        return jnp.array(False)

    def record(self, state, command):
        return self.gyrostat.record(state, command)
