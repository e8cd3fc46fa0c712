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
"""Fraction of the wheels' torque that may be used to turn their momentum with the body."""
ROLL_SHARE = 0.9
"""Fraction of that torque that the roll may use."""
BRAKING_SHARE = 0.5
"""Fraction of the wheels' torque that is used for braking."""
LAG_DAMPING = 1.6
"""Gain of the lag over sqrt(tilting acceleration / tilt)."""
WAYS_ROUND = np.array(list(product((0.0, -2.0 * np.pi, 2.0 * np.pi), repeat=2)))
"""Full turns that can be added to roll and spin, (9, 2), rad."""
KEPT = 0.7
"""Factor on the time of the present path when paths are compared: another must be much faster."""
LEAST_ROLL = 0.01
"""Smallest roll rate, rad/s, assumed when paths are compared. Wheels that are saturated at the
present attitude are not saturated on the whole path."""
UPRIGHT = 0.9999995
"""Largest commanded |cos| of the angle between normal and momentum."""


class Way(NamedTuple):
    """Path to the target: angles to be undone, one of the choices that differ by full turns.

    Attributes:
        roll: Angle about the momentum, rad.
        spin: Angle about the normal, rad.
    """

    roll: Scalar
    spin: Scalar


NO_WAY = Way(100.0, 100.0)
"""Value before the first sample. It differs from every path, since all angles are within 3 pi. It
is finite, because a guarded controller needs a finite memory."""


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
    """Largest speed of approach: `gain` times a small error, sqrt(2 a error) for a large one.

    Args:
        error: Remaining angle, rad.
        gain: Gain for a small error, 1/s.
        deceleration: Deceleration a for stopping, rad/s².

    Returns:
        Rate from which the motion can still stop at zero error, with the sign of the error, rad/s.
    """
    return gain * error / jnp.sqrt(1.0 + jnp.abs(error) * gain**2 / (2.0 * deceleration))


def largest_inertia(inertia) -> Scalar:
    """Upper bound of the largest principal inertia (Gershgorin), kg·m²."""
    return jnp.max(jnp.sum(jnp.abs(inertia), axis=1))


class TwoWheelLaw(Checked):
    """Commanded rate as a function of attitude, for working axes in a plane with normal n.

    The wheels determine every component of J w but n.J w = s = n.b - c. Here b = R' H is the total
    momentum in body axes, and c is the momentum of the failed wheels along n. Rest requires s = 0.
    In the angles of `momentum_angles`

        w = roll' b/|b| + spin' n + tilt' t,   tilt = theta_target - theta,
        n.Jn spin' + n.Jb/|b| roll' + n.Jt tilt' = s = |b| cos(theta) - c.

    Roll and tilt can be commanded freely. The lag z = n.Jn spin + n.Jb/|b| roll + n.Jt tilt changes
    only through s, with z' = s at small angles, and s changes when the normal tilts towards the
    momentum or away from it. The law is therefore s_d = -S tanh(k z / S), theta_d = acos((c +
    s_d)/|b|), tilt' = k' (theta - theta_d) - theta_d', a cascade whose linear part has the rates k
    and k' exactly. S is the largest s within the limits of the tilt. The torque of the wheels also
    limits s, since their momentum turns with the body.

    Paths to one attitude differ by full turns of roll and spin. The law takes the fastest path, and
    keeps it until another is much faster: the cosine is one-sided where |n x b| is small, and a
    roll may need momentum that one of the wheels does not have left.

    Derived for this package from the reduced gyrostat, whose rate is J^-1 (b - p - A h).

    Attributes:
        wheels: Rate loop that follows the commanded rate; it has the inertia and the limits.
        normal: Normal n of the working axes, (3,).
        target: Target quaternion, scalar first, (4,); a feasible attitude.
        total_momentum: Total momentum H in inertial axes, (3,), N·m·s.
        tilt_gain: Gain k' of the tilt, 1/s.
        roll_gain: Gain of the roll, 1/s.
        lag_gain: Largest gain k of the lag, 1/s.
        largest_tilt: Largest tilt beyond the feasible angle, rad; also limited to half the angle to
            where n and b align.
        largest_rate: Largest rate of roll and tilt, rad/s.
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
        """Commanded body rate.

        Args:
            attitude: Attitude quaternion, scalar first, (4,).
            held: Momentum c of the failed wheels along n, N·m·s.
            momentum: Wheel momentum at which the body would be at rest in this attitude, (wheels,),
                N·m·s.
            way: Path at the last sample; `NO_WAY` at the start.

        Returns:
            Body rate, (3,), rad/s, and the present path.
        """
        at = self._geometry(rotations.to_body(attitude, self.total_momentum))
        held = jnp.clip(held, -UPRIGHT * at.size, UPRIGHT * at.size)
        limits = self._authority(at, held, momentum)
        end = self._geometry(rotations.to_body(self.target, self.total_momentum))
        end_momentum = momentum + self.wheels.allocation @ (end.body - at.body)
        way, lag = self._way(way, attitude, at, limits, self._authority(end, held, end_momentum))
        roll_rate = self._roll_rate(way.roll, at, limits)
        tilt_rate = self._tilt_rate(lag, roll_rate, held, at, limits)
        frame = at.frame
        tilt_axis = frame.tangent - self.normal * at.tilt_inertia / at.spin_inertia
        drift = self.normal * (frame.along - held) / at.spin_inertia
        return roll_rate * at.roll_axis + tilt_rate * tilt_axis + drift, way

    def _geometry(self, body: Vector3) -> _Geometry:
        coupling = jnp.asarray(self.wheels.inertia) @ self.normal
        size, frame = jnp.sqrt(body @ body), momentum_frame(self.normal, body)
        by_normal, by_roll = self.normal @ coupling, coupling @ body / size
        # a roll with this spin rate does not change the lag
        roll_axis = body / size - self.normal * by_roll / by_normal
        turn = jnp.sqrt(roll_axis @ roll_axis + 1e-12)
        tilt = coupling @ frame.tangent
        return _Geometry(body, size, frame, by_normal, by_roll, tilt, roll_axis, turn)

    def _authority(self, at: _Geometry, held: Scalar, momentum: PerWheel) -> _Authority:
        wheels = self.wheels
        rest_angle = jnp.arccos(held / at.size)
        tilt_down = jnp.minimum(self.largest_tilt, 0.5 * rest_angle)
        tilt_up = jnp.minimum(self.largest_tilt, 0.5 * (jnp.pi - rest_angle))
        torque = GYROSCOPIC_SHARE * wheels.torque_along(at.frame.tangent)
        # a forward roll of the body takes momentum from the wheels
        backward, forward = wheels.room(momentum, jnp.asarray(wheels.inertia) @ at.roll_axis)
        anywhere = wheels.torque_anywhere()
        return _Authority(
            gives=at.size * jnp.cos(rest_angle - tilt_down) - held,
            takes=held - at.size * jnp.cos(rest_angle + tilt_up),
            turning=at.spin_inertia * torque / jnp.maximum(at.frame.across, 1e-6),
            slowing=BRAKING_SHARE * anywhere / largest_inertia(wheels.inertia),
            leaning=anywhere / jnp.maximum(jnp.abs(at.frame.along), 1e-9),
            forward=jnp.maximum(forward, 1e-4),
            backward=jnp.maximum(backward, 1e-4),
        )

    def _way(
        self, last: Way, attitude: Quaternion, at: _Geometry, limits: _Authority, end: _Authority
    ) -> tuple[Way, Scalar]:
        """Fastest path and its lag, from the authority here and at the target."""
        forward = jnp.maximum(jnp.minimum(limits.forward, end.forward), LEAST_ROLL / at.roll_turn)
        backward = jnp.maximum(
            jnp.minimum(limits.backward, end.backward), LEAST_ROLL / at.roll_turn
        )
        angles = momentum_angles(attitude, self.target, self.total_momentum, self.normal)
        roll, spin = angles.roll + WAYS_ROUND[:, 0], angles.spin + WAYS_ROUND[:, 1]
        lag = at.spin_inertia * spin + at.roll_inertia * roll + at.tilt_inertia * angles.tilt
        rolling = 2.0 * jnp.sqrt(jnp.abs(roll) * at.roll_turn / limits.slowing)
        rolling += jnp.abs(roll) / jnp.where(roll > 0.0, backward, forward)
        times = jnp.stack(
            [
                rolling,
                jnp.abs(lag) / jnp.where(lag > 0.0, limits.takes, limits.gives),
                jnp.abs(spin) * at.spin_inertia / limits.turning,
            ]
        )
        # the motions run at the same time but share the torque of the wheels
        total = jnp.max(times, axis=0) + 0.1 * jnp.sum(times, axis=0)
        is_present = (jnp.abs(roll - last.roll) < np.pi) & (jnp.abs(spin - last.spin) < np.pi)
        index = jnp.argmin(jnp.where(is_present, KEPT * total, total))
        return Way(roll[index], spin[index]), lag[index]

    def _roll_rate(self, roll: Scalar, at: _Geometry, limits: _Authority) -> Scalar:
        turn = at.roll_turn
        rate = -brake(roll * turn, self.roll_gain, limits.slowing) / turn
        share = ROLL_SHARE * limits.turning / jnp.maximum(jnp.abs(at.roll_inertia), 1e-9)
        limit = jnp.minimum(self.largest_rate / turn, share)
        return jnp.clip(
            rate, -jnp.minimum(limit, limits.backward), jnp.minimum(limit, limits.forward)
        )

    def _tilt_rate(self, lag, roll_rate, held, at: _Geometry, limits: _Authority) -> Scalar:
        frame, size = at.frame, at.size

        def angle_for(drift):
            return jnp.arccos(jnp.clip((held + drift) / size, -UPRIGHT, UPRIGHT))

        reach = jnp.where(lag > 0.0, limits.takes, limits.gives)
        widest_drift = jnp.where(lag > 0.0, -1.0, 1.0) * jnp.minimum(reach, limits.turning)
        lean = jnp.maximum(jnp.abs(angle_for(widest_drift) - angle_for(0.0)), 1e-3)
        gain = jnp.minimum(self.lag_gain, LAG_DAMPING * jnp.sqrt(limits.slowing / lean))
        # tilting back turns the momentum along the normal, which takes torque too; where the
        # drift is one-sided, an overshoot of the lag costs a full turn
        gain = jnp.minimum(gain, limits.leaning / lean)
        level = jnp.tanh(gain * lag / reach)
        centre = roll_rate * at.roll_inertia
        target_drift = jnp.clip(-reach * level, centre - limits.turning, centre + limits.turning)
        slope = jnp.where(target_drift == -reach * level, -gain * (1.0 - level**2), 0.0)
        aim = angle_for(target_drift)
        leading = slope * (frame.along - held) / (size * jnp.sin(aim))
        rate = brake(frame.angle - aim, self.tilt_gain, limits.slowing) + leading
        return jnp.clip(rate, -self.largest_rate, self.largest_rate)
