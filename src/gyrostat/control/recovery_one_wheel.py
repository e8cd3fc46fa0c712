"""Recovery with one working wheel, where the momentum lends it the other two directions."""

from typing import Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, ArrayLike, Bool, Float

from gyrostat import _types
from gyrostat._jax import jnp
from gyrostat.body import Spacecraft, WheelTorqueCommand, rotations
from gyrostat.body.rotations import Quaternion, Vector
from gyrostat.control.lqr import lqr
from gyrostat.errors import InputError
from gyrostat.friction import Scalar
from gyrostat.require import require

PerWheel = Float[Array, " wheels"]

SPAN = 1e-6
"""Of a singular value of the working axes: below it they do not reach that direction."""
LEAST_SINE = 1e-3
"""Of the angles on which controllability rests: below it motion takes too long to be of use."""
DAMPING = 1.0
"""Of the wheel's torque over rate, N·m·s/rad, where the total momentum is 1 N·m·s."""
RESTORING = 0.5
"""Of the energy kept with the wheel's momentum over that with the body's."""
ROLL_WEIGHT = 0.3
"""Of a roll, where that of a tilt is 1, both in rad."""
MOMENTUM_WEIGHT = 1.0
"""Of the wheel's momentum over the total momentum."""
TORQUE_WEIGHT = 1.0
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


class OneWheelRecovery(eqx.Module):
    """Brings a spacecraft with one direction of torque to rest at a holdable attitude.

    With h the momentum of the working wheel along its axis a, p that of the failed ones, both in
    inertial space, and b = R'H the total momentum in body axes, J w = b - p - a h. The body's
    energy E = w.Jw / 2 obeys dE/dt = -(a.w) h', the gyroscopic part does no work.

    Far from rest h' = c (a.w - s k) with k = h - h_d, limited or not, takes from E + s k²/2; s keeps
    h near that at the target, for the wheel could hold the momentum at another h as well.
    At rest |p + a h| = |H|, which fixes b: what is left free is a turn about H, the roll. All those
    attitudes are alike, so that one gain serves them all.
    Near rest h' = -K (tilt, roll, k) with the gain of `lqr` for

        d/dt (t, k) = [[J^-1 [b]x, -J^-1 a], [0, 0]] (t, k) + (0, h'),

    the turn t from the target in body axes. Of the roll no more than `widest_roll` is seen, as if
    the target were turned about H to be that near.

    k is taken from attitude and rate, a.(b - b_d - J w), not from the wheel's speed: so nothing
    need be known of p along a, and at rest nothing of J.

    Attributes:
        inertia: (3, 3) of the body without the rotors' own spin, kg·m².
        axis: (3,) a, unit length.
        allocation: (wheels,) of a torque along a.
        total_momentum: (3,) in inertial axes, N·m·s.
        target: (4,) attitude, scalar first.
        gain: (4,) K: of the turn, N·m/rad, and of k, 1/s.
        damping: c, N·m·s/rad.
        restoring: s, rad/s over N·m·s.
        torque_limit: (wheels,), N·m.
        momentum_limit: (wheels,), relative to the body, N·m·s.
        widest_roll: rad.
        inner: near rest begins below it: the larger of tilt in rad and |J w|/|H|.
        outer: and ends above it.
    """

    inertia: Float[Array, "3 3"]
    axis: Vector
    allocation: PerWheel
    total_momentum: Vector
    target: Quaternion
    gain: Float[Array, "4"]
    damping: Scalar
    restoring: Scalar
    torque_limit: PerWheel
    momentum_limit: PerWheel
    widest_roll: Scalar = 0.4
    inner: Scalar = 0.4
    outer: Scalar = 0.9

    def check(self) -> None:
        """Refuse gains and bounds that are not positive, by `InputError`."""
        for name in ("damping", "restoring", "widest_roll", "inner", "outer"):
            require(f"recovery {name}", getattr(self, name), positive=True)

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
            measurement: has `attitude` (4,), `rate` (3,), rad/s, and `wheel_momentum` (wheels,)
                seen from the body, N·m·s.
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
        seen = tilt + jnp.clip(roll, -self.widest_roll, self.widest_roll) * wanted / size
        regulated = -self.gain @ jnp.append(seen, excess)
        damped = self.damping * (self.axis @ rate - self.restoring * excess)
        torque = self.allocation * jnp.where(near, regulated, damped)
        torque = jnp.clip(torque, -limit, limit)
        relative, period = measurement.wheel_momentum, memory.period
        lowest = jnp.minimum((-self.momentum_limit - relative) / period, 0.0)
        highest = jnp.maximum((self.momentum_limit - relative) / period, 0.0)
        torque = jnp.where(self.allocation != 0.0, jnp.clip(torque, lowest, highest), 0.0)
        return OneWheelMemory(near, roll, period), WheelTorqueCommand(torque)

    def _turn(self, last: Scalar, attitude: Quaternion, along: Vector) -> tuple[Scalar, Vector]:
        """Roll about the momentum and the shortest turn after it, across the momentum."""
        turn = rotations.error(attitude, self.target)
        roll = 2.0 * jnp.arctan2(turn[1:] @ along, turn[0])
        twist = rotations.from_rotation_vector(roll * along)
        tilt = rotations.rotation_vector(rotations.product(rotations.conjugate(twist), turn))
        # half a turn away, noise must not choose the way round at each sample anew
        other = roll - 2.0 * jnp.pi * jnp.sign(roll)
        keep = (roll * last < 0.0) & (jnp.abs(last) > 2.0) & (jnp.abs(other) < 4.0)
        return jnp.where(keep, other, roll), tilt

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
        works = np.broadcast_to(np.asarray(working, dtype=bool), (wheels.count,))
        axes = np.asarray(wheels.axes, dtype=float)
        own = np.asarray(wheels.inertia, dtype=float) * np.ones(wheels.count)
        fixed = np.zeros(wheels.count) if seized is None else np.asarray(seized, dtype=float)
        inertia = np.asarray(spacecraft.inertia) + (axes * own * fixed) @ axes.T
        left, sizes, _ = np.linalg.svd(axes * works)
        rank = int(np.sum(sizes > SPAN))
        if rank != 1:
            raise InputError(f"working wheels: found axes that span {rank} directions, expected 1")
        # its sense is that of the first working wheel
        axis = left[:, 0] * np.sign(left[:, 0] @ axes[:, np.argmax(works)])
        share = axis @ (axes * works)
        attitude = rotations.normalised(jnp.asarray(target, dtype=float))
        momentum = jnp.asarray(total_momentum, dtype=float)
        body = np.asarray(rotations.to_body(attitude, momentum))
        _check_controllable(inertia, axis, body)
        limits = np.asarray(wheels.torque_limit) * np.ones(wheels.count)
        size = float(np.linalg.norm(body))
        mean = float(np.trace(inertia)) / 3.0
        return cls(
            inertia=jnp.asarray(inertia),
            axis=jnp.asarray(axis),
            allocation=jnp.asarray(share / (share @ share)),
            total_momentum=momentum,
            target=attitude,
            gain=jnp.asarray(_gain(inertia, axis, body, float(limits @ np.abs(share)))),
            damping=DAMPING * size,
            restoring=RESTORING / mean,
            torque_limit=jnp.asarray(limits),
            momentum_limit=jnp.ones(wheels.count) * wheels.momentum_limit,
        )


def _check_controllable(inertia: _types.Matrix, axis: _types.Vector, body: _types.Vector) -> None:
    """Refuse a target about which one wheel does not control the attitude."""
    size = float(np.linalg.norm(body))
    if size == 0.0:
        raise InputError("total momentum: found none, expected some: one wheel turns one axis only")
    along, turned = body / size, np.linalg.solve(inertia, axis)
    if abs(axis @ along) < LEAST_SINE:
        raise InputError(
            "target: found the momentum there at right angles to the axis of the working wheel "
            "(a.b = 0), expected some along it: the turn about the momentum is out of its reach"
        )
    if np.linalg.norm(np.cross(along, turned / np.linalg.norm(turned))) < LEAST_SINE:
        raise InputError(
            "target: found that the working wheel turns the spacecraft about the momentum there "
            "only (b x J^-1 a = 0), expected an angle between: the nutation is out of its reach"
        )


def _gain(
    inertia: _types.Matrix, axis: _types.Vector, body: _types.Vector, limit: float
) -> _types.Vector:
    """K over (turn, k), designed in units of |H| and J/|H|, so that one set of weights fits all."""
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
    return gain * np.array([size, size, size, 1.0]) / time
