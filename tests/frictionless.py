"""Wheels without friction on a rigid body, for tests that need a plant that compiles soon."""

import equinox as eqx

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.core.rotations import normalised, rate_of_quaternion, to_body
from gyrostat.spacecraft import Gyrostat, GyrostatState


class Frictionless(eqx.Module):
    """Wheels without friction on a body: one Runge-Kutta step, which compiles soon."""

    gyrostat: Gyrostat

    @property
    def spacecraft(self):
        return self.gyrostat.spacecraft

    def start(self, **motion):
        return self.gyrostat.start(**motion)

    def rate(self, state):
        return self.gyrostat.rate(state)

    def __call__(self, state, command, time, duration):
        """dq/dt and dw/dt at a constant momentum."""
        wheels = self.gyrostat.spacecraft.wheels

        def slope(state):
            rate = self.gyrostat.rate(state)
            turning = jnp.cross(rate, to_body(state.attitude, state.momentum))
            inverse = inverse_definite(jnp.asarray(self.gyrostat.spacecraft.inertia))
            turn = inverse @ (-turning - wheels.axes @ command.torque)
            speed = command.torque / wheels.inertia - wheels.axes.T @ turn
            return GyrostatState(rate_of_quaternion(state.attitude, rate), jnp.zeros(3), speed)

        def stage(carry, share):
            total, rate = carry
            reach, weight = share
            there = jax.tree.map(lambda y, k: y + reach * duration * k, state, rate)
            rate = slope(there)
            return (jax.tree.map(lambda y, k: y + weight * duration * k, total, rate), rate), None

        shares = (jnp.array([0.0, 0.5, 0.5, 1.0]), jnp.array([1.0, 2.0, 2.0, 1.0]) / 6.0)
        nothing = jax.tree.map(jnp.zeros_like, state)
        after = jax.lax.scan(stage, (state, nothing), shares)[0][0]
        return after._replace(attitude=normalised(after.attitude)), jnp.array(True)

    def diverged(self, state):
        return jnp.array(False)

    def record(self, state, command):
        return self.gyrostat.record(state, command)
