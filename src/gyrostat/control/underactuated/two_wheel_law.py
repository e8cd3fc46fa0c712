"""Body-rate command that brings a spacecraft with two working wheels to a feasible attitude."""

from itertools import product
from typing import Annotated, NamedTuple

import numpy as np

from gyrostat.control.attitude.wheel_rate_loop import WheelRateLoop
from gyrostat.control.underactuated.momentum_angles import (
    MomentumFrame,
    momentum_angles,
    momentum_frame,
)
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive
from gyrostat.core.jax64 import jnp

GYROSCOPIC_SHARE = 0.97
"""Of the wheels' torque that turning their momentum with the body may take."""
ROLL_SHARE = 0.9
"""Of that, what the roll may take."""
BRAKING_SHARE = 0.5
"""Of the wheels' torque that braking counts on."""
LAG_DAMPING = 1.6
"""Gain of the lag over sqrt(tilting acceleration / tilt)."""
WAYS_ROUND = np.array(list(product((0.0, -2.0 * np.pi, 2.0 * np.pi), repeat=2)))
"""Of roll and spin, rad."""
KEPT = 0.7
"""Weight of the time of the way round taken so far: another has to be much quicker."""
LEAST_ROLL = 0.01
"""rad/s, for comparing ways round: wheels that are full here will not be all the way."""
UPRIGHT = 0.9999995
"""Largest |cos| of the angle between normal and momentum that is aimed at."""


class Way(NamedTuple):
    """How far there is to go back, of the ways round to one attitude.

    Attributes:
        roll: about the momentum, rad.
        spin: about the normal, rad.
    """

    roll: Scalar
    spin: Scalar


NO_WAY = Way(100.0, 100.0)
"""Before the first sample: far from every way, all within 3 pi, and finite, because a guarded
controller keeps no other memory."""


class _Geometry(NamedTuple):
    body: Vector3
    size: Scalar
    frame: MomentumFrame
    spin_inertia: Scalar
    roll_inertia: Scalar
    tilt_inertia: Scalar
    roll_axis: Vector3
    roll_turn: Scalar


class _Authority(NamedTuple):
    gives: Scalar
    takes: Scalar
    turning: Scalar
    slowing: Scalar
    leaning: Scalar
    forward: Scalar
    backward: Scalar


def brake(error: Scalar, gain: Scalar, deceleration: Scalar) -> Scalar:
    """A speed from which one can stop: `gain` times a small error, sqrt(2 a error) for a large."""
    return gain * error / jnp.sqrt(1.0 + jnp.abs(error) * gain**2 / (2.0 * deceleration))


def largest_inertia(inertia) -> Scalar:
    """A bound of the largest principal inertia (Gershgorin), kg·m²."""
    return jnp.max(jnp.sum(jnp.abs(inertia), axis=1))


class TwoWheelLaw(Checked):
    """Rate over attitude, for working axes that span a plane with normal n.

    The wheels choose J w but for n.J w = s = n.b - c: b = R' H is the total momentum in body axes
    and c what the failed wheels hold along n; rest needs s = 0. In the angles of `momentum_angles`

        w = roll' b/|b| + spin' n + tilt' t,   tilt = theta_target - theta,
        n.Jn spin' + n.Jb/|b| roll' + n.Jt tilt' = s = |b| cos(theta) - c.

    Roll and tilt are commanded at will. The lag z = n.Jn spin + n.Jb/|b| roll + n.Jt tilt moves by
    s alone, z' = s at small angles, and s by tilting the normal towards or away from the
    momentum. So s_d = -S tanh(k z / S), theta_d = acos((c + s_d)/|b|), tilt' = k' (theta -
    theta_d) - theta_d', a cascade whose linear part has the rates k and k' exactly. S is what the
    tilt gives, s is also kept to what the wheels' torque allows, since their momentum turns with
    the body. Of the ways round that end at one attitude the quickest is taken, and kept until
    another is much quicker: the cosine is one-sided where |n x b| is small, and a roll may need
    momentum that one of the wheels has not left.

    Derived for this package from the reduced gyrostat, whose rate is J^-1 (b - p - A h).

    Attributes:
        wheels: the loop that will follow the rate; gives inertia and limits.
        normal: (3,) n.
        target: (4,) attitude to reach; holdable.
        total_momentum: (3,) H in inertial axes, N·m·s.
        tilt_gain: k', 1/s.
        roll_gain: 1/s.
        lag_gain: largest k, 1/s.
        largest_tilt: beyond the holdable angle, rad; at most half the way to where n and b align.
        largest_rate: of roll and tilt, rad/s.
    """

    wheels: WheelRateLoop
    normal: Vector3
    target: Quaternion
    total_momentum: Vector3
    tilt_gain: Annotated[Scalar, positive("tilt gain", "1/s")] = 0.4
    roll_gain: Annotated[Scalar, positive("roll gain", "1/s")] = 0.25
    lag_gain: Annotated[Scalar, positive("lag gain", "1/s")] = 0.2
    largest_tilt: Annotated[Scalar, positive("largest tilt", "rad")] = 1.0
    largest_rate: Annotated[Scalar, positive("largest rate", "rad/s")] = 0.1

    def __call__(
        self, attitude: Quaternion, held: Scalar, momentum: PerWheel, way: Way
    ) -> tuple[Vector3, Way]:
        """The rate to follow.

        Args:
            attitude: (4,) quaternion, scalar first.
            held: c, N·m·s.
            momentum: (wheels,) that would bring the body to rest here, N·m·s.
            way: taken so far, `NO_WAY` at the start.

        Returns:
            The body rate, rad/s, and the way round that it takes.
        """
        at = self._geometry(rotations.to_body(attitude, self.total_momentum))
        held = jnp.clip(held, -UPRIGHT * at.size, UPRIGHT * at.size)
        able = self._authority(at, held, momentum)
        end = self._geometry(rotations.to_body(self.target, self.total_momentum))
        carried = momentum + self.wheels.allocation @ (end.body - at.body)
        way, lag = self._way(way, attitude, at, able, self._authority(end, held, carried))
        roll_rate = self._roll_rate(way.roll, at, able)
        tilt_rate = self._tilt_rate(lag, roll_rate, held, at, able)
        frame = at.frame
        tilt_axis = frame.tangent - self.normal * at.tilt_inertia / at.spin_inertia
        drift = self.normal * (frame.along - held) / at.spin_inertia
        return roll_rate * at.roll_axis + tilt_rate * tilt_axis + drift, way

    def _geometry(self, body: Vector3) -> _Geometry:
        coupling = jnp.asarray(self.wheels.inertia) @ self.normal
        size, frame = jnp.sqrt(body @ body), momentum_frame(self.normal, body)
        own, by_roll = self.normal @ coupling, coupling @ body / size
        # rolling and letting the spin give way leaves the lag alone
        roll_axis = body / size - self.normal * by_roll / own
        turn = jnp.sqrt(roll_axis @ roll_axis + 1e-12)
        tilt = coupling @ frame.tangent
        return _Geometry(body, size, frame, own, by_roll, tilt, roll_axis, turn)

    def _authority(self, at: _Geometry, held: Scalar, momentum: PerWheel) -> _Authority:
        wheels = self.wheels
        rest = jnp.arccos(held / at.size)
        less = jnp.minimum(self.largest_tilt, 0.5 * rest)
        more = jnp.minimum(self.largest_tilt, 0.5 * (jnp.pi - rest))
        torque = GYROSCOPIC_SHARE * wheels.torque_along(at.frame.tangent)
        # a body that rolls forward takes its momentum from the wheels
        backward, forward = wheels.room(momentum, jnp.asarray(wheels.inertia) @ at.roll_axis)
        anywhere = wheels.torque_anywhere()
        return _Authority(
            gives=at.size * jnp.cos(rest - less) - held,
            takes=held - at.size * jnp.cos(rest + more),
            turning=at.spin_inertia * torque / jnp.maximum(at.frame.across, 1e-6),
            slowing=BRAKING_SHARE * anywhere / largest_inertia(wheels.inertia),
            leaning=anywhere / jnp.maximum(jnp.abs(at.frame.along), 1e-9),
            forward=jnp.maximum(forward, 1e-4),
            backward=jnp.maximum(backward, 1e-4),
        )

    def _way(
        self, last: Way, attitude: Quaternion, at: _Geometry, able: _Authority, then: _Authority
    ) -> tuple[Way, Scalar]:
        """The way round and its lag, by what is possible here and at the target."""
        forward = jnp.maximum(jnp.minimum(able.forward, then.forward), LEAST_ROLL / at.roll_turn)
        backward = jnp.maximum(jnp.minimum(able.backward, then.backward), LEAST_ROLL / at.roll_turn)
        angles = momentum_angles(attitude, self.target, self.total_momentum, self.normal)
        roll, spin = angles.roll + WAYS_ROUND[:, 0], angles.spin + WAYS_ROUND[:, 1]
        lag = at.spin_inertia * spin + at.roll_inertia * roll + at.tilt_inertia * angles.tilt
        rolling = 2.0 * jnp.sqrt(jnp.abs(roll) * at.roll_turn / able.slowing)
        rolling += jnp.abs(roll) / jnp.where(roll > 0.0, backward, forward)
        times = jnp.stack(
            [
                rolling,
                jnp.abs(lag) / jnp.where(lag > 0.0, able.takes, able.gives),
                jnp.abs(spin) * at.spin_inertia / able.turning,
            ]
        )
        # they run at once, but share the wheels
        total = jnp.max(times, axis=0) + 0.1 * jnp.sum(times, axis=0)
        same = (jnp.abs(roll - last.roll) < np.pi) & (jnp.abs(spin - last.spin) < np.pi)
        best = jnp.argmin(jnp.where(same, KEPT * total, total))
        return Way(roll[best], spin[best]), lag[best]

    def _roll_rate(self, roll: Scalar, at: _Geometry, able: _Authority) -> Scalar:
        turn = at.roll_turn
        rate = -brake(roll * turn, self.roll_gain, able.slowing) / turn
        share = ROLL_SHARE * able.turning / jnp.maximum(jnp.abs(at.roll_inertia), 1e-9)
        limit = jnp.minimum(self.largest_rate / turn, share)
        return jnp.clip(rate, -jnp.minimum(limit, able.backward), jnp.minimum(limit, able.forward))

    def _tilt_rate(self, lag, roll_rate, held, at: _Geometry, able: _Authority) -> Scalar:
        frame, size = at.frame, at.size

        def angle_for(drift):
            return jnp.arccos(jnp.clip((held + drift) / size, -UPRIGHT, UPRIGHT))

        reach = jnp.where(lag > 0.0, able.takes, able.gives)
        used = jnp.where(lag > 0.0, -1.0, 1.0) * jnp.minimum(reach, able.turning)
        lean = jnp.maximum(jnp.abs(angle_for(used) - angle_for(0.0)), 1e-3)
        gain = jnp.minimum(self.lag_gain, LAG_DAMPING * jnp.sqrt(able.slowing / lean))
        # tilting back turns the momentum along the normal, which takes torque too: where drift is
        # one-sided, a lag that passes zero costs a whole turn
        gain = jnp.minimum(gain, able.leaning / lean)
        level = jnp.tanh(gain * lag / reach)
        centre = roll_rate * at.roll_inertia
        wanted = jnp.clip(-reach * level, centre - able.turning, centre + able.turning)
        slope = jnp.where(wanted == -reach * level, -gain * (1.0 - level**2), 0.0)
        aim = angle_for(wanted)
        leading = slope * (frame.along - held) / (size * jnp.sin(aim))
        rate = brake(frame.angle - aim, self.tilt_gain, able.slowing) + leading
        return jnp.clip(rate, -self.largest_rate, self.largest_rate)
