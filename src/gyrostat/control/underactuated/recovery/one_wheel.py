"""Recovery law for one working wheel and nonzero total momentum."""

from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from jaxtyping import Array, ArrayLike, Bool, Float

from gyrostat.control.allocation.working_wheels import SPAN, WorkingWheels
from gyrostat.control.design.lqr import lqr
from gyrostat.core import rotations, types
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft import Spacecraft, WheelTorqueCommand

LEAST_SINE = 1e-3
"""Of the angles on which controllability rests: below it motion takes too long to be of use."""
DAMPING = 1.0
"""Rate at which a small tilt goes, over |H|/J and the sine of the angle from b to J^-1 a."""
FOLLOWING = 2.0
"""Rate at which the wheel follows, over |H|/J."""
TORQUE_SHARE = 0.7
"""Of the torque limit, that damping may take at the rate |H|/J."""
LEAN = 0.4
"""Tilt, rad, at a roll that is as wide as any seen."""
REACH = 0.4
"""Share of a.b that the wheel's momentum may take away to that end."""
WIDEST = 1.5
"""Of the rolls seen, rad."""
ROLL_WEIGHT = 1.0
"""Of a roll, where that of a tilt is 1, both in rad."""
STAYING = 0.3
"""Roll by which the way round is kept beyond where the other is quicker, rad."""
MOMENTUM_WEIGHT = 0.1
"""Of the wheel's momentum over the total momentum."""
TORQUE_WEIGHT = 0.3
"""Of its torque over the total momentum in the time J/|H|."""
LIMIT_WEIGHT = 0.05
"""Of its torque over its limit, where that is more."""


class OneWheelMemory(NamedTuple):
    """Between two samples.

    Attributes:
        near: whether the body is near rest somewhere on the circle of attitudes that can be held.
        roll: about the total momentum from the target, rad.
        period: control period, s.
    """

    near: Bool[Array, ""]
    roll: Scalar
    period: Scalar


class OneWheelRecovery(Checked):
    """Brings a spacecraft with one direction of torque to rest at a holdable attitude.

    With h the momentum of the working wheel along its axis a, p that of the failed ones, both in
    inertial space, and b = R'H the total momentum in body axes, J w = b - p - a h and b' = b x w.
    With k = h - h_d from that at the target, D = b - b_d and y = J^-1 D: J w = D - a k, and

        d/dt (D.J^-1 D / 2) = -k y.(b x J^-1 a).

    Far from rest k follows c y.(b x J^-1 a), limited, and D goes. At rest b = b_d, and what is left
    free is a turn about H, the roll. All those attitudes are alike, so that one gain serves them.
    Near rest h' = -K (tilt, roll, k) with the gain of `lqr` for

        d/dt (t, k) = [[J^-1 [b]x, -J^-1 a], [0, 0]] (t, k) + (0, h'),

    the turn t from the target in body axes. No more of the roll is seen than `widest_roll`, as if
    the target were turned about H to be that near: then the body spins slowly about H, and its
    tilt and k are those that `LEAN` and `REACH` allow. The way round is the one that is quicker.

    k is taken from attitude and rate, a.(b - b_d - J w), not from the wheel's speed: so nothing
    need be known of p along a, and at rest nothing of J.

    Attributes:
        inertia: (3, 3) of the body without the rotors' own spin, kg·m².
        axis: (3,) a, unit length.
        allocation: (wheels,) of a torque along a.
        total_momentum: (3,) in inertial axes, N·m·s.
        target: (4,) attitude, scalar first.
        gain: (4,) K: of the turn, N·m/rad, and of k, 1/s.
        damping: c, kg·m²·s.
        following: rate at which k follows, 1/s.
        widest_excess: of k where it damps, N·m·s.
        widest_roll: (2,) lowest, below zero, and highest, rad.
        torque_limit: (wheels,), N·m.
        momentum_limit: (wheels,), relative to the body, N·m·s.
        rotor_inertia: (wheels,) about the spin axes, kg·m².
        inner: near rest begins below it: the larger of tilt in rad and |J w|/|H|.
        outer: and ends above it.
    """

    inertia: Float[Array, "3 3"]
    axis: Vector3
    allocation: PerWheel
    total_momentum: Vector3
    target: Quaternion
    gain: Float[Array, "4"]
    damping: Annotated[Scalar, positive("recovery damping")]
    following: Annotated[Scalar, positive("recovery following")]
    widest_excess: Annotated[Scalar, positive("recovery widest_excess")]
    widest_roll: Float[Array, "2"]
    torque_limit: PerWheel
    momentum_limit: PerWheel
    rotor_inertia: PerWheel
    inner: Annotated[Scalar, positive("recovery inner")] = 0.8
    outer: Annotated[Scalar, positive("recovery outer")] = 1.4

    def start(self, period: Scalar) -> OneWheelMemory:
        """Far from rest."""
        period = jnp.asarray(period, dtype=float)
        return OneWheelMemory(jnp.array(False), jnp.zeros(()), period)

    def __call__(
        self, memory: OneWheelMemory, measurement: Any
    ) -> tuple[OneWheelMemory, WheelTorqueCommand]:
        """Command the working wheels.

        Args:
            memory: from the last sample.
            measurement: has `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed` (wheels,)
                relative to the body, rad/s.
        """
        rate, limit = measurement.rate, jnp.asarray(self.torque_limit)
        body = rotations.to_body(measurement.attitude, self.total_momentum)
        wanted = rotations.to_body(self.target, self.total_momentum)
        size = jnp.sqrt(wanted @ wanted)
        spun = jnp.asarray(self.inertia) @ rate
        excess = self.axis @ (body - wanted - spun)
        roll, tilt = self._turn(memory.roll, measurement.attitude, wanted / size)
        distance = jnp.maximum(jnp.sqrt(tilt @ tilt), jnp.sqrt(spun @ spun) / size)
        near = distance < jnp.where(memory.near, self.outer, self.inner)
        seen = tilt + jnp.clip(roll, *self.widest_roll) * wanted / size
        regulated = -self.gain @ jnp.append(seen, excess)
        share, change = jax.jvp(
            lambda momentum: self.damping_excess(momentum, wanted),
            (body,),
            (jnp.cross(body, rate),),
        )
        damped = change - self.following * (excess - share)
        torque = self.allocation * jnp.where(near, regulated, damped)
        torque = jnp.clip(torque, -limit, limit)
        relative, period = self.rotor_inertia * measurement.wheel_speed, memory.period
        lowest = jnp.minimum((-self.momentum_limit - relative) / period, 0.0)
        highest = jnp.maximum((self.momentum_limit - relative) / period, 0.0)
        torque = jnp.where(self.allocation != 0.0, jnp.clip(torque, lowest, highest), 0.0)
        return OneWheelMemory(near, roll, period), WheelTorqueCommand(torque)

    def damping_excess(self, body: Vector3, wanted: Vector3) -> Scalar:
        """Excess k that takes away b - b_d, N·m·s.

        Args:
            body: (3,) total momentum in body axes, N·m·s.
            wanted: (3,) b_d, the same at the target.
        """
        inverse = inverse_definite(jnp.asarray(self.inertia))
        away = inverse @ (body - wanted)
        share = self.damping * away @ jnp.cross(body, inverse @ self.axis)
        return jnp.clip(share, -self.widest_excess, self.widest_excess)

    def _turn(self, last: Scalar, attitude: Quaternion, along: Vector3) -> tuple[Scalar, Vector3]:
        """Roll about the momentum and the shortest turn after it, across the momentum."""
        turn = rotations.error(attitude, self.target)
        roll = 2.0 * jnp.arctan2(turn[1:] @ along, turn[0])
        twist = rotations.from_rotation_vector(roll * along)
        tilt = rotations.rotation_vector(rotations.product(rotations.conjugate(twist), turn))
        lowest, highest = self.widest_roll
        # both ways take the same time there; noise must not choose anew at each sample
        turned = 2.0 * jnp.pi * highest / (highest - lowest)
        turned = turned + STAYING * jnp.where(jnp.abs(last) > STAYING, jnp.sign(last), 0.0)
        roll = jnp.where(roll > turned, roll - 2.0 * jnp.pi, roll)
        return jnp.where(roll < turned - 2.0 * jnp.pi, roll + 2.0 * jnp.pi, roll), tilt

    @classmethod
    def plan(
        cls,
        spacecraft: Spacecraft,
        working: ArrayLike,
        *,
        total_momentum: ArrayLike,
        target: ArrayLike,
        seized: ArrayLike | None = None,
    ) -> Self:
        """The controller for one failure; done once, outside the loop.

        Args:
            spacecraft: as the controller knows it, one.
            working: (wheels,) whether a wheel works.
            total_momentum: (3,) in inertial axes, N·m·s.
            target: (4,) holdable attitude, scalar first.
            seized: (wheels,) whether the rotor is fixed to the body; None for none.

        Raises:
            InputError: the working wheels do not share one axis, or do not control the attitude
                about the target: a.b = 0 or b x J^-1 a = 0.
        """
        wheels = spacecraft.wheels
        left = WorkingWheels.of(spacecraft, working, seized)
        if left.rank != 1:
            raise InputError(
                f"working wheels: found axes that span {left.rank} directions, expected 1"
            )
        # its sense is that of the first working wheel
        axis = left.directions[:, 0]
        axis = axis * np.sign(axis @ left.axes[:, np.argmax(left.works)])
        share = axis @ left.axes
        inertia = left.inertia
        attitude = rotations.normalised(jnp.asarray(target, dtype=float))
        momentum = jnp.asarray(total_momentum, dtype=float)
        body = np.asarray(rotations.to_body(attitude, momentum))
        sine = _checked_sine(inertia, axis, body)
        limits = np.asarray(wheels.torque_limit) * np.ones(wheels.count)
        size = float(np.linalg.norm(body))
        mean = float(np.trace(inertia)) / 3.0
        limit = float(limits @ np.abs(share))
        gain, widest = _regulator(inertia, axis, body, limit)
        return cls(
            inertia=jnp.asarray(inertia),
            axis=jnp.asarray(axis),
            allocation=jnp.asarray(share / (share @ share)),
            total_momentum=momentum,
            target=attitude,
            gain=jnp.asarray(gain),
            damping=DAMPING * mean**2 / (size * sine),
            following=FOLLOWING * size / mean,
            widest_excess=min(size, TORQUE_SHARE * limit * mean / size),
            widest_roll=jnp.asarray(widest),
            torque_limit=jnp.asarray(limits),
            momentum_limit=jnp.ones(wheels.count) * wheels.momentum_limit,
            rotor_inertia=jnp.asarray(left.rotor_inertia),
        )


def _checked_sine(inertia: types.Matrix, axis: types.Vector, body: types.Vector) -> float:
    """Of the angle from b to J^-1 a; refuses where one wheel does not control the attitude."""
    size = float(np.linalg.norm(body))
    if size == 0.0:
        raise InputError("total momentum: found none, expected some: one wheel turns one axis only")
    along, turned = body / size, np.linalg.solve(inertia, axis)
    if abs(axis @ along) < LEAST_SINE:
        raise InputError(
            "target: found the momentum there at right angles to the axis of the working wheel "
            "(a.b = 0), expected some along it: the turn about the momentum is out of its reach"
        )
    sine = float(np.linalg.norm(np.cross(along, turned / np.linalg.norm(turned))))
    if sine < LEAST_SINE:
        raise InputError(
            "target: found that the working wheel turns the spacecraft about the momentum there "
            "only (b x J^-1 a = 0), expected an angle between: the nutation is out of its reach"
        )
    return sine


def _regulator(
    inertia: types.Matrix, axis: types.Vector, body: types.Vector, limit: float
) -> tuple[types.Vector, types.Vector]:
    """Gain over (turn, k) and the lowest and highest roll that it is to see.

    In units of |H| and J/|H|, so that one set of weights fits all.
    """
    size = float(np.linalg.norm(body))
    along, time = body / size, float(np.trace(inertia)) / 3.0 / size
    inverse = np.linalg.inv(inertia) * time * size
    dynamics = np.zeros((4, 4))
    dynamics[:3, :3] = inverse @ np.cross(np.eye(3), along)
    dynamics[:3, 3] = -inverse @ axis
    weight = np.eye(4)
    weight[:3, :3] += (ROLL_WEIGHT - 1.0) * np.outer(along, along)
    weight[3, 3] = MOMENTUM_WEIGHT
    cost = max(TORQUE_WEIGHT, LIMIT_WEIGHT * (size / time / limit) ** 2)
    gain = np.asarray(lqr(dynamics, np.eye(4)[:, 3:], weight, cost * np.eye(1)).gain)[0]
    # tilt and k of the steady spin at a roll that is seen as 1 rad
    across = np.eye(4)[:, 1:]
    across[:3, :2] = np.linalg.svd(along[None])[2][1:].T
    across[:, 2] = np.eye(4)[3]
    closed = across.T @ (dynamics - np.outer(np.eye(4)[3], gain)) @ across
    steady = np.linalg.solve(closed, np.array([0.0, 0.0, gain[:3] @ along]))
    widest = min(WIDEST, LEAN / max(float(np.hypot(*steady[:2])), SPAN))
    least = REACH * abs(axis @ along) / max(abs(steady[2]), SPAN)
    bounds = np.array([-widest, widest])
    against = bounds * steady[2] * (axis @ along) < 0.0
    bounds = np.where(against, np.clip(bounds, -least, least), bounds)
    return gain * np.array([size, size, size, 1.0]) / time, bounds
