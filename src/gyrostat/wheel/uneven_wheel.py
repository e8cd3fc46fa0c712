"""Speed of a wheel whose friction varies over the angle of the rotor and over time.

J dw/dt = k_m I - g(t) F(w) + sum_h a_h sin(n_h q + p_h), dq/dt = w, by midpoint steps of fixed
length. A wheel that changes sense rests for the remainder of the step, and at rest until motor and
ripple torque exceed the breakaway torque. First order in the step at crossings and breakaways.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Matrix, Vector
from gyrostat.wheel.wheel import Wheel

ORDERS = (1.0, 5.0)
"""Periods in a turn of the harmonics of a usual ripple."""
SECOND = 0.5
"""Amplitude of its second harmonic over that of the first."""
STEP = 2e-3
"""Longest step, s."""


class Ripple(NamedTuple):
    """Torque over the angle of the rotor, h harmonics on each of c wheels.

    Attributes:
        amplitude: Amplitudes, (c, h), N·m.
        order: Periods per turn, (c, h).
        phase: Phases at the start, (c, h), rad.
    """

    amplitude: Matrix
    order: Matrix
    phase: Matrix

    @classmethod
    def usual(cls, rms: float | Vector, phase: Matrix) -> "Ripple":
        """Ripple of two harmonics.

        Args:
            rms: Root mean square over a turn, of all wheels or of each, (c,), N·m.
            phase: Phases at the start, (c, 2), rad.
        """
        first = np.broadcast_to(rms * np.sqrt(2.0 / (1.0 + SECOND**2)), len(phase))
        orders = np.tile(ORDERS, (len(phase), 1))
        return cls(np.column_stack([first, SECOND * first]), orders, phase)


@lru_cache
def _program(substeps: int):
    """Compile the speeds of wheels that share their currents."""

    def lane(wheel, current, interval, growth, ripple):
        step = interval / substeps

        def waves(angle):
            return jnp.sum(ripple.amplitude * jnp.sin(ripple.order * angle + ripple.phase))

        def acceleration(speed, angle, sense, load, scale):
            friction = scale * wheel.friction.torque(speed, sense)
            return (load + waves(angle) - friction) / wheel.inertia

        def substep(_, carry, load, scale):
            speed, angle = carry
            drive = load + waves(angle)
            sense = jnp.where(speed == 0.0, jnp.sign(drive), jnp.sign(speed))
            breakaway = scale * wheel.friction.breakaway_torque(sense)
            rests = (speed == 0.0) & (jnp.abs(drive) <= breakaway)
            half = speed + 0.5 * step * acceleration(speed, angle, sense, load, scale)
            middle = angle + 0.5 * step * speed
            end = speed + step * acceleration(half, middle, sense, load, scale)
            end = jnp.where(rests | (end * sense < 0.0), 0.0, end)
            return end, angle + 0.5 * step * (speed + end)

        def sample(carry, entry):
            load = wheel.motor_constant * entry[0]
            carry = jax.lax.fori_loop(
                0, substeps, lambda k, each: substep(k, each, load, entry[1]), carry
            )
            return carry, carry[0]

        zero = jnp.zeros(())
        speeds = jax.lax.scan(sample, (zero, zero), (current[:-1], growth[:-1]))[1]
        return jnp.concatenate([zero[None], speeds])

    return jax.jit(jax.vmap(lane, (0, None, None, 0, 0)))


def uneven_speeds(
    wheel: Wheel, time: Vector, current: Vector, growth: Matrix, ripple: Ripple
) -> Matrix:
    """Speeds of wheels that start from rest, (c, N), rad/s.

    Args:
        wheel: Wheel with a static friction curve; each parameter is one number, or one for each
            record, (c,).
        time: Sample times, (N,), s, evenly spaced.
        current: Current, held from sample to sample, (N,), A.
        growth: Friction over its mean, (c, N).
        ripple: Torque over the angle.
    """
    interval = float(time[-1] - time[0]) / (len(time) - 1)
    program = _program(int(np.ceil(interval / STEP * (1.0 - 1e-9))))
    wheels = jax.tree.map(lambda leaf: jnp.broadcast_to(leaf, (len(growth),)), wheel)
    return np.asarray(program(wheels, jnp.asarray(current), interval, jnp.asarray(growth), ripple))
