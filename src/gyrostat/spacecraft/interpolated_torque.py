"""External torques over one interval, interpolated so that each is evaluated twice only."""

from dataclasses import replace
from typing import Any

import equinox as eqx
from jaxtyping import Array, Bool

from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.rotations import from_rotation_vector, product, rate_of_quaternion, to_body
from gyrostat.spacecraft.gyrostat_state import GyrostatState
from gyrostat.spacecraft.spacecraft import Spacecraft
from gyrostat.spacecraft.wheel_friction import advanced, net_torque
from gyrostat.spacecraft.wheels_on_body import WheelsOnBody

REACH = 0.02
"""Largest rotation of the body in one interval of interpolation, rad."""
MOST = 1000
"""Largest number of intervals of interpolation in one step."""


_Parts = tuple[Any, GyrostatState, Bool[Array, ""]]
"""Number of the next part, state, and whether all parts so far were resolved."""


class InterpolatedTorque(eqx.Module):
    """External torque of a body as a cubic function of time within one interval.

    The cubic has the values and slopes of the torque at both ends (Hermite). The attitude at the
    end is extrapolated. The error within an interval of length t is of fourth order: ((w t)⁴ +
    3 a² t⁴) / 384 of the torque at the rate w and the acceleration a, such as 2e-11 at 2 deg/s in
    0.25 s.

    Attributes:
        body: Plant with `spacecraft`, and with the torque `exact_torque` over attitude and time,
            which is not interpolated.
        started: Time at the start, s.
        cubic: Coefficients of the powers of time from the start, (4, 3), N·m/s^k.
    """

    body: Any
    started: Scalar
    cubic: tuple[Vector3, Vector3, Vector3, Vector3]

    @property
    def spacecraft(self) -> Spacecraft:
        """Body and wheels."""
        return self.body.spacecraft

    def torque(self, attitude: Quaternion, time: Scalar) -> Vector3:
        """External torque in body axes, (3,), N·m, at a time, s."""
        since = time - self.started
        start, slope, square, cube = self.cubic
        slow = start + since * (slope + since * (square + since * cube))
        return self.body.exact_torque(attitude, time) + slow


def advanced_with_interpolated_torque(
    contacts: WheelsOnBody, state: GyrostatState, duration: Scalar
) -> tuple[GyrostatState, Bool[Array, ""]]:
    """State at the end of an interval, s, and whether the interval was resolved.

    The interval is divided so that the body turns by at most `REACH` in each part, which is no
    longer than `longest_step` of an actuator with a state. An interval that needs more than `MOST`
    parts for it counts as not resolved.

    Args:
        contacts: Equations of motion over the interval; their `body` is a `Gyrostat`.
        state: State at the start.
        duration: Length of the interval, s.
    """
    rate = contacts.body.rate(state)
    nutation = contacts.inverse @ to_body(state.attitude, state.momentum)
    fastest = jnp.sqrt(jnp.maximum(rate @ rate, nutation @ nutation))
    parts, resolvable = fastest * duration / REACH, jnp.array(True)
    for item in contacts.body.environment:
        longest = getattr(item, "longest_step", None)
        if longest is not None:
            parts = jnp.maximum(parts, duration / longest)
            resolvable = resolvable & (duration <= MOST * longest)
    count = jnp.ceil(jnp.clip(parts, 1.0, MOST)).astype(int)
    length = duration / count

    def part(carried: _Parts) -> _Parts:
        number, state, fine = carried
        time = contacts.started + number * length
        body = with_interpolated_torque(contacts, state, time, length)
        part_contacts = replace(contacts, body=body, started=time)
        state, resolved = advanced(part_contacts, state, length)
        return number + 1, state, fine & resolved

    def goes_on(carried: _Parts) -> Bool[Array, ""]:
        # flight code needs an explicit bound
        return (carried[0] < count) & (carried[0] < MOST)

    return jax.lax.while_loop(goes_on, part, (0, state, resolvable))[1:]


def with_interpolated_torque(
    contacts: WheelsOnBody, state: GyrostatState, time: Scalar, duration: Scalar
) -> InterpolatedTorque:
    """Body of the wheels with torques of environment and actuators interpolated over an interval.

    Args:
        contacts: Equations of motion.
        state: State at the start.
        time: Time at the start, s.
        duration: Length of the interval, s.
    """
    plant = contacts.body

    def along(attitude: Quaternion, rate: Vector3, time: Scalar) -> tuple[Vector3, Vector3]:
        moving = (rate_of_quaternion(attitude, rate), jnp.ones_like(time))
        return jax.jvp(plant.slow_torque, (attitude, time), moving)

    time = jnp.asarray(time, dtype=float)
    start, slope = along(state.attitude, plant.rate(state), time)
    end, end_slope = along(*_end(contacts, state, start, slope, duration), time + duration)
    length = jnp.where(duration > 0.0, duration, 1.0)
    mean = (end - start) / length
    square = (3.0 * mean - 2.0 * slope - end_slope) / length
    cube = (slope + end_slope - 2.0 * mean) / length**2
    return InterpolatedTorque(plant, time, (start, slope, square, cube))


def _end(
    contacts: WheelsOnBody, state: GyrostatState, torque: Vector3, slope: Vector3, duration: Scalar
) -> tuple[Quaternion, Vector3]:
    """Attitude and body rate at the end, extrapolated with the wheel torques of the start.

    Args:
        contacts: Equations of motion.
        state: State at the start.
        torque: External torque at the start, (3,), N·m.
        slope: Its time derivative, (3,), N·m/s.
        duration: Length of the interval, s.
    """
    wheels, rate = contacts.body.spacecraft.wheels, contacts.body.rate(state)
    driven = contacts.torque - contacts.added_viscous * state.wheel_speed
    net = net_torque(contacts.friction, driven, state)
    momentum = to_body(state.attitude, state.momentum)
    gained = torque - jnp.cross(rate, momentum)
    acceleration = contacts.inverse @ (gained - jnp.asarray(wheels.axes) @ net)
    change = slope - jnp.cross(acceleration, momentum) - jnp.cross(rate, gained)
    jerk = contacts.inverse @ change
    # the last term is that of an axis of rotation that moves (J. E. Bortz, 1971)
    mean = rate + duration * (
        acceleration / 2.0 + duration * (jerk / 6.0 + jnp.cross(rate, acceleration) / 12.0)
    )
    attitude = product(state.attitude, from_rotation_vector(duration * mean))
    return attitude, rate + duration * (acceleration + duration * jerk / 2.0)
