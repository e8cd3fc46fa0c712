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
"""Smallest sine of the angles that controllability depends on; below it the motion is too slow."""
DAMPING = 1.0
"""Rate of decay of a small tilt, over |H|/J and the sine of the angle from b to J^-1 a."""
FOLLOWING = 2.0
"""Rate at which the wheel momentum follows its command, over |H|/J."""
TORQUE_SHARE = 0.7
"""Fraction of the torque limit that damping may use at the rate |H|/J."""
LEAN = 0.4
"""Largest tilt of the steady spin, rad; it limits the roll that the regulator uses."""
REACH = 0.4
"""Largest k of the steady spin, as a fraction of a.b; it limits that roll too."""
WIDEST = 1.5
"""Largest roll that the regulator uses, rad."""
ROLL_WEIGHT = 1.0
"""Weight of the roll, with a weight of 1 for the tilt, both in rad."""
STAYING = 0.3
"""Hysteresis of the direction of rotation: roll beyond the point where both are as fast, rad."""
MOMENTUM_WEIGHT = 0.1
"""Weight of the wheel momentum over the total momentum."""
TORQUE_WEIGHT = 0.3
"""Weight of the wheel torque over the total momentum in the time J/|H|."""
LIMIT_WEIGHT = 0.05
"""Weight of the wheel torque over its limit, used where it is larger."""


class OneWheelMemory(NamedTuple):
    """State of the controller between two samples.

    Attributes:
        near: Whether the body is near rest at some attitude on the circle of feasible attitudes.
        roll: Roll about the total momentum from the target, rad.
        period: Control period, s.
    """

    near: Bool[Array, ""]
    roll: Scalar
    period: Scalar


class OneWheelRecovery(Checked):
    """Recovery to rest at a feasible attitude, with wheel torque about one axis.

    h is the momentum of the working wheel along its axis a, and p that of the failed wheels, both
    in inertial space. With the total momentum b = R'H in body axes, J w = b - p - a h and b' = b x
    w. With k = h - h_d, where h_d is the value at the target, D = b - b_d and y = J^-1 D: J w = D -
    a k, and

        d/dt (D.J^-1 D / 2) = -k y.(b x J^-1 a).

    Far from rest, k follows c y.(b x J^-1 a), limited, so that D decays. At rest b = b_d, and the
    attitude may differ from the target only by a rotation about H, the roll. The dynamics are the
    same at all these attitudes, so that one gain is valid for them. Near rest h' = -K (tilt, roll,
    k), with the gain of `lqr` for

        d/dt (t, k) = [[J^-1 [b]x, -J^-1 a], [0, 0]] (t, k) + (0, h'),

    where t is the rotation from the target in body axes. The regulator uses a roll limited to
    `widest_roll`, as for a nearer target. The body then spins slowly about H, with tilt and k
    within `LEAN` and `REACH`. The faster direction of rotation is taken.

    k is computed from attitude and rate, a.(b - b_d - J w), not from the wheel speed. The component
    of p along a is therefore not needed, and at rest J is not needed either.

    Attributes:
        inertia: Inertia of the body without the rotors' spin inertia, (3, 3), kg·m².
        axis: Axis a of the wheel torque, unit length, (3,).
        allocation: Allocation of a torque along a to the wheels, (wheels,).
        total_momentum: Total momentum in inertial axes, (3,), N·m·s.
        target: Target quaternion, scalar first, (4,).
        gain: Gain K, (4,): of the rotation, N·m/rad, and of k, 1/s.
        damping: Gain c, kg·m²·s.
        following: Rate at which k follows its command, 1/s.
        widest_excess: Largest k while damping, N·m·s.
        widest_roll: Lowest roll, below zero, and highest roll that the regulator uses, (2,), rad.
        torque_limit: Torque limits, (wheels,), N·m.
        momentum_limit: Limits of the momentum relative to the body, (wheels,), N·m·s.
        rotor_inertia: Inertia of the rotors about their axes, (wheels,), kg·m².
        inner: Distance from rest below which the body counts as near rest: the larger of tilt in
            rad and |J w|/|H|.
        outer: Distance from rest above which the body no longer counts as near rest.
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
        """Initial memory, not near rest."""
        period = jnp.asarray(period, dtype=float)
        return OneWheelMemory(jnp.array(False), jnp.zeros(()), period)

    def __call__(
        self, memory: OneWheelMemory, measurement: Any
    ) -> tuple[OneWheelMemory, WheelTorqueCommand]:
        """Compute the wheel torques.

        Args:
            memory: Memory from the last sample.
            measurement: Measurement with `attitude` (4,), `rate` (3,), rad/s, and `wheel_speed`
                (wheels,), relative to the body, rad/s.
        """
        rate, limit = measurement.rate, jnp.asarray(self.torque_limit)
        body = rotations.to_body(measurement.attitude, self.total_momentum)
        target_momentum = rotations.to_body(self.target, self.total_momentum)
        size = jnp.sqrt(target_momentum @ target_momentum)
        spin = jnp.asarray(self.inertia) @ rate
        excess = self.axis @ (body - target_momentum - spin)
        roll, tilt = self._turn(memory.roll, measurement.attitude, target_momentum / size)
        distance = jnp.maximum(jnp.sqrt(tilt @ tilt), jnp.sqrt(spin @ spin) / size)
        near = distance < jnp.where(memory.near, self.outer, self.inner)
        rotation = tilt + jnp.clip(roll, *self.widest_roll) * target_momentum / size
        regulated = -self.gain @ jnp.append(rotation, excess)
        share, change = jax.jvp(
            lambda momentum: self.damping_excess(momentum, target_momentum),
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
        """Excess momentum k that reduces b - b_d, N·m·s.

        Args:
            body: Total momentum in body axes, (3,), N·m·s.
            wanted: Total momentum b_d in body axes at the target, (3,), N·m·s.
        """
        inverse = inverse_definite(jnp.asarray(self.inertia))
        away = inverse @ (body - wanted)
        share = self.damping * away @ jnp.cross(body, inverse @ self.axis)
        return jnp.clip(share, -self.widest_excess, self.widest_excess)

    def _turn(self, last: Scalar, attitude: Quaternion, along: Vector3) -> tuple[Scalar, Vector3]:
        """Roll about the momentum, and the shortest remaining rotation, orthogonal to it."""
        turn = rotations.error(attitude, self.target)
        roll = 2.0 * jnp.arctan2(turn[1:] @ along, turn[0])
        twist = rotations.from_rotation_vector(roll * along)
        tilt = rotations.rotation_vector(rotations.product(rotations.conjugate(twist), turn))
        lowest, highest = self.widest_roll
        # both directions take the same time there; the hysteresis keeps noise from switching
        threshold = 2.0 * jnp.pi * highest / (highest - lowest)
        threshold = threshold + STAYING * jnp.where(jnp.abs(last) > STAYING, jnp.sign(last), 0.0)
        roll = jnp.where(roll > threshold, roll - 2.0 * jnp.pi, roll)
        return jnp.where(roll < threshold - 2.0 * jnp.pi, roll + 2.0 * jnp.pi, roll), tilt

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
        """Design the controller for one failure case; done once, outside the loop.

        Args:
            spacecraft: Spacecraft model of the controller, without a batch axis.
            working: Whether each wheel works, (wheels,).
            total_momentum: Total momentum in inertial axes, (3,), N·m·s.
            target: Target quaternion, scalar first, (4,); a feasible attitude.
            seized: Whether each rotor is fixed to the body, (wheels,); None for no seized rotor.

        Raises:
            InputError: The working wheels do not share one axis, or do not control the attitude
                near the target: a.b = 0 or b x J^-1 a = 0.
        """
        wheels = spacecraft.wheels
        subset = WorkingWheels.of(spacecraft, working, seized)
        if subset.rank != 1:
            raise InputError(
                f"working wheels: found axes that span {subset.rank} directions, expected 1"
            )
        # the sign of the axis is that of the first working wheel
        axis = subset.directions[:, 0]
        axis = axis * np.sign(axis @ subset.axes[:, np.argmax(subset.works)])
        share = axis @ subset.axes
        inertia = subset.inertia
        attitude = rotations.normalised(jnp.asarray(target, dtype=float))
        momentum = jnp.asarray(total_momentum, dtype=float)
        body = np.asarray(rotations.to_body(attitude, momentum))
        sine = _damping_sine(inertia, axis, body)
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
            rotor_inertia=jnp.asarray(subset.rotor_inertia),
        )


def _damping_sine(inertia: types.Matrix, axis: types.Vector, body: types.Vector) -> float:
    """Sine of the angle from b to J^-1 a.

    Raises:
        InputError: One wheel does not control the attitude.
    """
    size = float(np.linalg.norm(body))
    if size == 0.0:
        raise InputError(
            "total momentum: found zero, expected more: one wheel alone controls one axis only"
        )
    along, response = body / size, np.linalg.solve(inertia, axis)
    if abs(axis @ along) < LEAST_SINE:
        raise InputError(
            "target: found the momentum orthogonal to the axis of the working wheel there "
            "(a.b = 0), expected a component along it: only this component changes the roll"
        )
    sine = float(np.linalg.norm(np.cross(along, response / np.linalg.norm(response))))
    if sine < LEAST_SINE:
        raise InputError(
            "target: found a wheel that turns the spacecraft about the momentum only there "
            "(b x J^-1 a = 0), expected an angle between them: it cannot damp the nutation"
        )
    return sine


def _regulator(
    inertia: types.Matrix, axis: types.Vector, body: types.Vector, limit: float
) -> tuple[types.Vector, types.Vector]:
    """Gain for (rotation, k), and the lowest and highest roll that the regulator uses.

    In units of |H| and J/|H|, so that one set of weights fits all cases.
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
    # tilt and k of the steady spin if the regulator uses a roll of 1 rad
    across = np.eye(4)[:, 1:]
    across[:3, :2] = np.linalg.svd(along[None])[2][1:].T
    across[:, 2] = np.eye(4)[3]
    closed_loop = across.T @ (dynamics - np.outer(np.eye(4)[3], gain)) @ across
    steady = np.linalg.solve(closed_loop, np.array([0.0, 0.0, gain[:3] @ along]))
    widest = min(WIDEST, LEAN / max(float(np.hypot(*steady[:2])), SPAN))
    reach = REACH * abs(axis @ along) / max(abs(steady[2]), SPAN)
    bounds = np.array([-widest, widest])
    against = bounds * steady[2] * (axis @ along) < 0.0
    bounds = np.where(against, np.clip(bounds, -reach, reach), bounds)
    return gain * np.array([size, size, size, 1.0]) / time, bounds
