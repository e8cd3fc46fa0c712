"""Sweeps of a spacecraft with two working wheels, including drift during the sweep."""

from typing import Any, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.control.allocation.working_wheels import SPAN, WorkingWheels
from gyrostat.control.underactuated.recovery.rest_to_rest import (
    Sweep,
    progress,
    shortest,
    timed,
    turned,
)
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft

AIMS = 8
"""Taken for a sweep, each corrected by the drift on the way of the one before."""
NODES = 32
"""Intervals in time in which that drift is summed up."""


class TwoWheelSweeps(eqx.Module):
    """What a body turns by when its working wheels span a plane and the others are seized.

    With n the normal of the working axes, H the total momentum and b = R'H, the rate w of a body
    of inertia J obeys n.J w = n.b whatever the wheels do: across z, along J n, it is commanded;
    along z it is the drift n.b / |J n|.

    Attributes:
        inertia: (3, 3) of all that turns with the body, seized rotors with it, without the axial
            inertia of the working rotors, kg·m².
        axes: (3, wheels) spin axes.
        rotor_inertia: (wheels,) axial inertia of the working rotors, 0 of the others, kg·m².
        allocation: (wheels, 3) pseudoinverse of the working axes, zero rows for the others.
        frame: (3, 3) sweep axes x, y, z in body axes, as columns.
        drift: (3,) n / |J n|, 1/(kg·m²).
        torque_limit: (wheels,) N·m.
        momentum_limit: (wheels,) N·m·s.
    """

    inertia: Float[Array, "3 3"]
    axes: Float[Array, "3 wheels"]
    rotor_inertia: PerWheel
    allocation: Float[Array, "wheels 3"]
    frame: Float[Array, "3 3"]
    drift: Vector3
    torque_limit: PerWheel
    momentum_limit: PerWheel

    @classmethod
    def of(cls, spacecraft: Spacecraft, working: Any) -> Self:
        """For a spacecraft of which some wheels have seized.

        Args:
            spacecraft: as known to the controller.
            working: (wheels,) bool; the others are seized.

        Raises:
            InputError: the working axes do not span a plane, a working wheel has no limits.
        """
        wheels = spacecraft.wheels
        working = np.asarray(working, dtype=bool)
        if working.shape != (wheels.count,):
            raise InputError(
                f"working wheels: found shape {working.shape}, expected ({wheels.count},)"
            )
        left = WorkingWheels.of(spacecraft, working, ~working)
        if left.rank != 2:
            raise InputError(f"working wheels: found axes of rank {left.rank}, expected 2, a plane")
        limits = [
            np.broadcast_to(np.asarray(limit, dtype=float), working.shape)
            for limit in (wheels.torque_limit, wheels.momentum_limit)
        ]
        if not all(np.all(np.isfinite(limit[working])) for limit in limits):
            raise InputError(
                "working wheels: found no limit of torque or momentum, expected finite ones: a "
                "sweep is as fast as they let it be"
            )
        inertia, normal = left.inertia, left.directions[:, 2]
        length = np.linalg.norm(inertia @ normal)
        z = inertia @ normal / length
        x = np.linalg.svd(z[None])[2][1]
        values = (
            inertia,
            np.asarray(wheels.axes, dtype=float),
            np.where(working, left.rotor_inertia, 0.0),
            np.linalg.pinv(left.axes, rcond=SPAN),
            np.stack([x, np.cross(z, x), z], axis=1),
            normal / length,
            *limits,
        )
        return cls(*(jnp.asarray(value) for value in values))

    def momentum(self, rate: Vector3, wheel_speed: PerWheel) -> Vector3:
        """Total momentum in body axes, N·m·s, from what is measured."""
        rotors = self.rotor_inertia * (wheel_speed + self.axes.T @ rate)
        return self.inertia @ rate + self.axes @ rotors

    def in_body(self, turn: Quaternion) -> Quaternion:
        """A turn in sweep axes, in body axes."""
        return jnp.concatenate([turn[:1], self.frame @ turn[1:]])

    def error(self, attitude: Quaternion, target: Quaternion) -> Vector3:
        """Rotation vector from a target to an attitude, sweep axes, rad."""
        return self.frame.T @ rotations.rotation_vector(rotations.error(attitude, target))

    def lever(self, attitude: Quaternion, momentum: Vector3) -> Vector3:
        """Change of the drift with the attitude, sweep axes, 1/s.

        Turned by e, n.b = n.(b - e x b) = n.b + e.(n x b).

        Args:
            attitude: at which.
            momentum: total, inertial axes, N·m·s.
        """
        return self.frame.T @ jnp.cross(self.drift, rotations.to_body(attitude, momentum))

    def torque(self, acceleration: Vector3, rate: Vector3, momentum: Vector3) -> PerWheel:
        """Torques that give an acceleration across z, all shortened alike to their limits, N·m.

        Args:
            acceleration: sweep axes, rad/s^2; that along z is what it is.
            rate: of the body, body axes, rad/s.
            momentum: total, body axes, N·m·s.
        """
        gyroscopic = jnp.cross(momentum, rate)
        wanted = acceleration.at[2].set(self.drift @ gyroscopic)
        torque = self.allocation @ (gyroscopic - self.inertia @ (self.frame @ wanted))
        return torque / jnp.maximum(jnp.max(jnp.abs(torque) / self.torque_limit), 1.0)

    def limits(self, momentum: Vector3, share: Scalar) -> tuple[Scalar, Scalar]:
        """What the wheels give about any axis of a sweep.

        Args:
            momentum: total, body axes, N·m·s; the wheels have to hold it beside the sweep's.
            share: of the limits of the wheels.

        Returns:
            Rate, rad/s, and its change, rad/s^2.
        """
        each = (self.allocation @ self.inertia @ self.frame)[:, :2]
        gain = jnp.maximum(jnp.sqrt(jnp.sum(each**2, axis=1)), 1e-12)
        held = jnp.sqrt(jnp.sum(self.allocation**2, axis=1) * (momentum @ momentum))
        room = share * jnp.maximum(self.momentum_limit - held, 0.01 * self.momentum_limit)
        return jnp.min(room / gain), jnp.min(share * self.torque_limit / gain)

    def planned(
        self,
        before: Sweep,
        begin: Bool[Array, ""],
        attitude: Quaternion,
        target: Quaternion,
        momentum: Vector3,
        share: Scalar,
    ) -> Sweep:
        """A new sweep where one begins, else the one before.

        Args:
            before: under way, or the last one.
            begin: whether a sweep begins.
            attitude: at its start.
            target: attitude at its end, reached with the drift on the way.
            momentum: total, inertial axes, N·m·s.
            share: of the limits of the wheels that it may take.
        """
        turn = rotations.product(rotations.conjugate(attitude), target)
        turn = jnp.concatenate([turn[:1], self.frame.T @ turn[1:]])
        limits = self.limits(momentum, share)

        def aim(planned):
            goal, _, number = planned
            sweep = timed(*shortest(goal), *limits)
            drifted = self.drifted(sweep, attitude, momentum)
            goal = rotations.product(rotations.conjugate(drifted), turn)
            return goal, sweep, number + 1

        # no round where none begins: a `cond` in a batch would plan for every run at every sample
        rounds = jnp.where(begin, AIMS, 0)

        def goes_on(planned):
            # flight code needs a constant bound, and reports when that is reached
            return (planned[2] < rounds) & (planned[2] <= AIMS)

        return jax.lax.while_loop(goes_on, aim, (turn, before, 0))[1]

    def drifted(self, sweep: Sweep, attitude: Quaternion, momentum: Vector3) -> Quaternion:
        """The turn D that the drift adds: a sweep r ends at D r, in sweep axes at its start.

        D' = D (r z) d with d the drift at the attitude D r, in steps of the midpoint rule.

        Args:
            sweep: from its start to its end.
            attitude: at its start.
            momentum: total, inertial axes, N·m·s.
        """
        step = sweep.duration / NODES
        z = jnp.array([0.0, 0.0, 1.0])

        def growth(turn, time, duration):
            way = turned(sweep, progress(sweep, time)[0])
            there = rotations.product(attitude, self.in_body(rotations.product(turn, way)))
            rate = self.drift @ rotations.to_body(there, momentum)
            return rotations.from_rotation_vector(rate * duration * rotations.to_inertial(way, z))

        def add(k, turn):
            half = rotations.product(turn, growth(turn, k * step, 0.5 * step))
            return rotations.product(turn, growth(half, (k + 0.5) * step, step))

        return jax.lax.fori_loop(0, NODES, add, jnp.array([1.0, 0.0, 0.0, 0.0]))
