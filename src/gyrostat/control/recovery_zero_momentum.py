"""Pointing with two wheels when there is next to no momentum."""

from typing import Any, NamedTuple

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat._jax import jax, jnp
from gyrostat.body import Spacecraft, rotations
from gyrostat.body.rotations import Quaternion, Vector
from gyrostat.control.rest_to_rest import (
    Sweep,
    progress,
    rate_axis,
    shortest,
    timed,
    turned,
)
from gyrostat.errors import InputError
from gyrostat.friction import Scalar
from gyrostat.wheel.array import PerWheel

AIMS = 4
"""Taken for a sweep, each corrected by the drift on the way of the one before."""
NODES = 32
"""Intervals in time in which that drift is summed up."""
NO_LEVER = 1e-9
"""N·m·s: a momentum across n below it holds nothing by leaning."""


class ZeroMomentumMemory(NamedTuple):
    """Between two samples.

    Attributes:
        sweep: under way, or the last one.
        elapsed: since its start, s.
        reference: attitude that the sweep would have reached now.
        arrived: whether the target is held.
        period: control period, s.
    """

    sweep: Sweep
    elapsed: Scalar
    reference: Quaternion
    arrived: Bool[Array, ""]
    period: Scalar


class ZeroMomentumCommand(NamedTuple):
    """Motor torques, and what they are for.

    Attributes:
        torque: (wheels,) on each rotor, N·m.
        started: 1 where a sweep starts at this sample, else 0.
        left: of the sweep under way, s.
    """

    torque: PerWheel
    started: Scalar
    left: Scalar

    UNITS = {"torque": "N·m", "started": "1", "left": "s"}  # noqa: RUF012


class ZeroMomentumRecovery(eqx.Module):
    """Sweeps of `rest_to_rest`, each tracked in two directions and planned again at its end.

    With n the normal of the working axes, the failed wheels seized, H0 the momentum and b = R'H0, the
    body rate w obeys n.J w = n.b whatever the wheels do. Without momentum no smooth feedback brings
    the attitude to rest at a target. This one

    - plans a sweep from rest, aimed so that it ends on target with the drift n.b on its way;
    - tracks it in the two directions that the wheels command; the reference takes over the body's
      own rate along J n, so that tracking never bends the way that was planned;
    - plans again at its end where the error along J n is above `fine`: each sweep leaves a small
      share of the error before it, of the order of what is wrong with the inertia;
    - holds the two commanded directions then, and what momentum there is holds the third: leaning
      by up to `lean` about the lever b x n makes n.b drive the error along J n to zero. Above
      `coarse` it plans again.

    Before a first sweep the body is brought to rest as far as the wheels can.

    Attributes:
        target: attitude to reach, one where n.b = 0.
        inertia: (3, 3) of all that turns with the body, seized rotors with it, without the axial
            inertia of the working rotors, kg·m².
        axes: (3, wheels) spin axes.
        rotor_inertia: (wheels,) axial inertia of those that still turn, 0 of seized ones, kg·m².
        allocation: (wheels, 3) pseudoinverse of the working axes, zero rows for the failed wheels.
        frame: (3, 3) sweep axes in body axes, the third along J n.
        drift: (3,) n / |J n|, so that drift.b is the rate along J n, 1/(kg·m²).
        torque_limit: (wheels,) N·m.
        momentum_limit: (wheels,) N·m·s.
        fine: error along J n that a sweep is planned for until the target is reached, rad.
        coarse: the same once it was reached, rad.
        lean: largest offset across J n while holding, rad.
        lean_gain: of the error along J n, 1/s.
        frequency: natural frequency of the tracking, rad/s, critically damped.
        share: of torque and momentum limit that a sweep is planned with.
        rest_rate: largest rate across J n at which a sweep is planned, rad/s.
    """

    target: Quaternion
    inertia: Float[Array, "3 3"]
    axes: Float[Array, "3 wheels"]
    rotor_inertia: PerWheel
    allocation: Float[Array, "wheels 3"]
    frame: Float[Array, "3 3"]
    drift: Vector
    torque_limit: PerWheel
    momentum_limit: PerWheel
    fine: Scalar = np.radians(0.01)
    coarse: Scalar = np.radians(0.04)
    lean: Scalar = np.radians(0.015)
    lean_gain: Scalar = 0.02
    frequency: Scalar = 0.5
    share: Scalar = 0.92
    rest_rate: Scalar = 1e-3

    @classmethod
    def of(
        cls,
        spacecraft: Spacecraft,
        working: Any,
        target: Quaternion,
        **tuning: Scalar,
    ) -> "ZeroMomentumRecovery":
        """For a spacecraft of which some wheels have failed.

        Args:
            spacecraft: as known to the controller.
            working: (wheels,) bool; the others are seized.
            target: attitude to reach.
            **tuning: other attributes.

        Raises:
            InputError: the working axes do not span a plane.
        """
        wheels = spacecraft.wheels
        working = np.asarray(working, dtype=bool)
        axes, inertia = np.asarray(wheels.axes, float), np.asarray(wheels.inertia, float)
        u, size, _ = np.linalg.svd(axes * working)
        if not (size[1] > 1e-6 and size[2] <= 1e-6):
            rank = int(np.sum(size > 1e-6))
            raise InputError(f"working wheels: found axes of rank {rank}, expected a plane (2)")
        normal = u[:, 2]
        seized = np.where(working, 0.0, inertia)
        body = np.asarray(spacecraft.inertia, float) + (axes * seized) @ axes.T
        z = body @ normal
        length = np.linalg.norm(z)
        plane = np.linalg.svd(z[None] / length)[2]
        x = plane[1]
        frame = np.stack([x, np.cross(z / length, x), z / length], axis=1)
        count = (wheels.count,)
        return cls(
            target=jnp.asarray(target, float),
            inertia=jnp.asarray(body),
            axes=jnp.asarray(axes),
            rotor_inertia=jnp.asarray(np.where(working, inertia, 0.0)),
            allocation=jnp.asarray(np.linalg.pinv(axes * working, rcond=1e-6)),
            frame=jnp.asarray(frame),
            drift=jnp.asarray(normal / length),
            torque_limit=jnp.broadcast_to(jnp.asarray(wheels.torque_limit, float), count),
            momentum_limit=jnp.broadcast_to(jnp.asarray(wheels.momentum_limit, float), count),
            **tuning,
        )

    def start(self, period: Scalar) -> ZeroMomentumMemory:
        """Nothing seen yet."""
        zero, one = jnp.array(0.0), jnp.array(1.0)
        none = Sweep(zero, zero, zero, one, zero)
        return ZeroMomentumMemory(
            none,
            zero,
            jnp.array([1.0, 0.0, 0.0, 0.0]),
            jnp.array(False),
            jnp.asarray(period, float),
        )

    def __call__(
        self, memory: ZeroMomentumMemory, measurement: Any
    ) -> tuple[ZeroMomentumMemory, ZeroMomentumCommand]:
        """Command torques.

        Args:
            memory: from the last sample.
            measurement: attitude, rate, rad/s, and wheel_momentum (wheels,) relative to the body.
        """
        attitude, rate = measurement.attitude, measurement.rate
        momentum = self._momentum(rate, measurement.wheel_momentum)
        across = self.frame.T @ rate
        error = self._error(attitude, self.target)
        memory, started = self._planned(memory, attitude, momentum, across, error)
        sweep, period = memory.sweep, memory.period
        angle, speed = progress(sweep, memory.elapsed)
        later_angle, later_speed = progress(sweep, memory.elapsed + period)
        wanted = speed * rate_axis(sweep, angle)
        later = later_speed * rate_axis(sweep, later_angle)
        left = sweep.duration - memory.elapsed
        held = jnp.where(memory.arrived, error - self._leaning(attitude, momentum, error), 0.0)
        missed = jnp.where(left > 0.0, self._error(attitude, memory.reference), held)
        feedback = self.frequency**2 * missed + 2.0 * self.frequency * (across - wanted)
        torque = self._torque((later - wanted) / period - feedback, rate, momentum)
        step = rotations.product(
            rotations.conjugate(turned(sweep, angle)), turned(sweep, later_angle)
        )
        own = rotations.from_rotation_vector(jnp.array([0.0, 0.0, 1.0]) * across[2] * period)
        step = self._in_body(rotations.product(step, own))
        memory = memory._replace(
            elapsed=memory.elapsed + period,
            reference=rotations.normalised(rotations.product(memory.reference, step)),
        )
        left = jnp.maximum(left, 0.0)
        return memory, ZeroMomentumCommand(torque, started.astype(float), left)

    def _momentum(self, rate: Vector, wheel_momentum: PerWheel) -> Vector:
        """Total momentum in body axes, N·m·s."""
        rotors = wheel_momentum + self.rotor_inertia * (self.axes.T @ rate)
        return self.inertia @ rate + self.axes @ rotors

    def _in_body(self, turn: Quaternion) -> Quaternion:
        """A turn in sweep axes, in body axes."""
        return jnp.concatenate([turn[:1], self.frame @ turn[1:]])

    def _error(self, attitude: Quaternion, target: Quaternion) -> Vector:
        """Rotation vector from a target to an attitude, sweep axes, rad."""
        return self.frame.T @ rotations.rotation_vector(rotations.error(attitude, target))

    def _planned(self, memory, attitude, momentum, across, error):
        """Start a sweep where the last one is over, the body at rest and the target missed."""
        over = memory.elapsed >= memory.sweep.duration
        slow = jnp.hypot(across[0], across[1]) < self.rest_rate
        tolerance = jnp.where(memory.arrived, self.coarse, self.fine)
        near = (jnp.abs(error[2]) < tolerance) & (jnp.hypot(error[0], error[1]) < 20.0 * tolerance)
        begin = over & slow & ~near
        sweep = self._sweep(memory.sweep, begin, attitude, momentum)
        return memory._replace(
            sweep=sweep,
            elapsed=jnp.where(begin, 0.0, memory.elapsed),
            reference=jnp.where(begin, attitude, memory.reference),
            arrived=(memory.arrived | (over & slow)) & ~begin,
        ), begin

    def _sweep(
        self, before: Sweep, begin: Bool[Array, ""], attitude: Quaternion, momentum: Vector
    ) -> Sweep:
        """Where one begins, a sweep that ends on target, the drift on its way included."""
        inertial = rotations.to_inertial(attitude, momentum)
        turn = rotations.product(rotations.conjugate(attitude), self.target)
        turn = jnp.concatenate([turn[:1], self.frame.T @ turn[1:]])
        limits = self._limits(momentum)

        def aim(_, planned):
            goal, _ = planned
            sweep = timed(*shortest(goal), *limits)
            drifted = self._drift(sweep, attitude, inertial)
            return rotations.product(rotations.conjugate(drifted), turn), sweep

        # no round where none begins: a `cond` in a batch would plan for every lane at every sample
        rounds = jnp.where(begin, AIMS, 0)
        return jax.lax.fori_loop(0, rounds, aim, (turn, before))[1]

    def _limits(self, momentum: Vector) -> tuple[Scalar, Scalar]:
        """Rate, rad/s, and its change, rad/s^2, that the wheels give about any axis of a sweep."""
        each = (self.allocation @ self.inertia @ self.frame)[:, :2]
        gain = jnp.maximum(jnp.sqrt(jnp.sum(each**2, axis=1)), 1e-12)
        held = jnp.sqrt(jnp.sum(self.allocation**2, axis=1) * (momentum @ momentum))
        room = jnp.maximum(self.share * self.momentum_limit - held, 0.01 * self.momentum_limit)
        return jnp.min(room / gain), jnp.min(self.share * self.torque_limit / gain)

    def _drift(self, sweep: Sweep, attitude: Quaternion, inertial: Vector) -> Quaternion:
        """Turn that the drift adds to a sweep, in sweep axes at its start.

        The attitude is D r with r of the sweep; D' = D (r z) d, d the drift at D r.
        """
        step = sweep.duration / NODES

        def add(k, drifted):
            way = turned(sweep, progress(sweep, (k + 0.5) * step)[0])
            there = rotations.product(attitude, self._in_body(rotations.product(drifted, way)))
            rate = self.drift @ rotations.to_body(there, inertial)
            axis = rotations.to_inertial(way, jnp.array([0.0, 0.0, 1.0]))
            return rotations.product(drifted, rotations.from_rotation_vector(rate * step * axis))

        return jax.lax.fori_loop(0, NODES, add, jnp.array([1.0, 0.0, 0.0, 0.0]))

    def _leaning(self, attitude: Quaternion, momentum: Vector, error: Vector) -> Vector:
        """Offset across J n, sweep axes, rad, at which the momentum takes away the error along it.

        At the target turned by e, n.b = e.(n x b_d): see `holdable`.
        """
        inertial = rotations.to_inertial(attitude, momentum)
        there = rotations.to_body(self.target, inertial)
        lever = self.frame.T @ jnp.cross(self.drift, there)
        lever = lever.at[2].set(0.0)
        size = jnp.sqrt(lever @ lever)
        has = size * jnp.sqrt(1.0 / (self.drift @ self.drift)) > NO_LEVER
        amount = -self.lean_gain * error[2] / jnp.where(has, size, 1.0)
        return (
            jnp.where(has, jnp.clip(amount, -self.lean, self.lean), 0.0)
            * lever
            / jnp.where(has, size, 1.0)
        )

    def _torque(self, acceleration: Vector, rate: Vector, momentum: Vector) -> PerWheel:
        """Torques that give an acceleration across J n, sweep axes, shortened to the limit."""
        gyroscopic = jnp.cross(momentum, rate)
        wanted = acceleration.at[2].set(self.drift @ gyroscopic)
        torque = self.allocation @ (gyroscopic - self.inertia @ (self.frame @ wanted))
        return torque / jnp.maximum(jnp.max(jnp.abs(torque) / self.torque_limit), 1.0)
