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
"""Number of iterations to plan a sweep; each corrects for the drift during the one before."""
NODES = 32
"""Number of time intervals in the integration of that drift."""


class TwoWheelSweeps(eqx.Module):
    """Rotations of a body whose working wheels span a plane and whose other wheels are seized.

    With n the normal of the working axes, H the total momentum and b = R'H, the rate w of a body of
    inertia J obeys n.J w = n.b at any wheel torque. Orthogonal to z, which is along J n, the rate
    can be commanded. Along z it is the drift n.b / |J n|.

    Attributes:
        inertia: Inertia of all that turns with the body, including seized rotors, without the axial
            inertia of the working rotors, (3, 3), kg·m².
        axes: Spin axes, (3, wheels).
        rotor_inertia: Axial inertia of the working rotors, zero for the others, (wheels,), kg·m².
        allocation: Pseudo-inverse of the working axes, with zero rows for the others, (wheels, 3).
        frame: Sweep axes x, y, z in body axes, as columns, (3, 3).
        drift: Vector n / |J n|, (3,), 1/(kg·m²).
        torque_limit: Torque limits, (wheels,), N·m.
        momentum_limit: Momentum limits, (wheels,), N·m·s.
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
        """Sweeps of a spacecraft with some seized wheels.

        Args:
            spacecraft: Spacecraft model of the controller.
            working: Whether each wheel works, (wheels,), bool; the others are seized.

        Raises:
            InputError: The working axes do not span a plane, or a working wheel has no limits.
        """
        wheels = spacecraft.wheels
        working = np.asarray(working, dtype=bool)
        if working.shape != (wheels.count,):
            raise InputError(
                f"working wheels: found shape {working.shape}, expected ({wheels.count},)"
            )
        subset = WorkingWheels.of(spacecraft, working, ~working)
        if subset.rank != 2:
            raise InputError(
                f"working wheels: found axes of rank {subset.rank}, expected 2, a plane"
            )
        limits = [
            np.broadcast_to(np.asarray(limit, dtype=float), working.shape)
            for limit in (wheels.torque_limit, wheels.momentum_limit)
        ]
        if not all(np.all(np.isfinite(limit[working])) for limit in limits):
            raise InputError(
                "working wheels: found no limit of torque or momentum, expected finite ones: a "
                "sweep is timed by them"
            )
        inertia, normal = subset.inertia, subset.directions[:, 2]
        length = np.linalg.norm(inertia @ normal)
        z = inertia @ normal / length
        x = np.linalg.svd(z[None])[2][1]
        values = (
            inertia,
            np.asarray(wheels.axes, dtype=float),
            np.where(working, subset.rotor_inertia, 0.0),
            np.linalg.pinv(subset.axes, rcond=SPAN),
            np.stack([x, np.cross(z, x), z], axis=1),
            normal / length,
            *limits,
        )
        return cls(*(jnp.asarray(value) for value in values))

    def momentum(self, rate: Vector3, wheel_speed: PerWheel) -> Vector3:
        """Total momentum in body axes, (3,), N·m·s, from measured rates."""
        rotors = self.rotor_inertia * (wheel_speed + self.axes.T @ rate)
        return self.inertia @ rate + self.axes @ rotors

    def in_body(self, turn: Quaternion) -> Quaternion:
        """Rotation given in sweep axes, expressed in body axes."""
        return jnp.concatenate([turn[:1], self.frame @ turn[1:]])

    def error(self, attitude: Quaternion, target: Quaternion) -> Vector3:
        """Rotation vector from a target to an attitude, in sweep axes, (3,), rad."""
        return self.frame.T @ rotations.rotation_vector(rotations.error(attitude, target))

    def lever(self, attitude: Quaternion, momentum: Vector3) -> Vector3:
        """Derivative of the drift with respect to attitude, in sweep axes, (3,), 1/s.

        After a rotation by e, n.b = n.(b - e x b) = n.b + e.(n x b).

        Args:
            attitude: Attitude quaternion at which the derivative is taken, (4,).
            momentum: Total momentum in inertial axes, (3,), N·m·s.
        """
        return self.frame.T @ jnp.cross(self.drift, rotations.to_body(attitude, momentum))

    def torque(self, acceleration: Vector3, rate: Vector3, momentum: Vector3) -> PerWheel:
        """Torques for an acceleration orthogonal to z, scaled to the limits, (wheels,), N·m.

        Args:
            acceleration: Acceleration in sweep axes, (3,), rad/s^2; the component along z is
                ignored.
            rate: Body rate in body axes, (3,), rad/s.
            momentum: Total momentum in body axes, (3,), N·m·s.
        """
        gyroscopic = jnp.cross(momentum, rate)
        demand = acceleration.at[2].set(self.drift @ gyroscopic)
        torque = self.allocation @ (gyroscopic - self.inertia @ (self.frame @ demand))
        return torque / jnp.maximum(jnp.max(jnp.abs(torque) / self.torque_limit), 1.0)

    def limits(self, momentum: Vector3, share: Scalar) -> tuple[Scalar, Scalar]:
        """Rate and acceleration that the wheels can give about every axis of a sweep.

        Args:
            momentum: Total momentum in body axes, (3,), N·m·s, which the wheels hold in addition.
            share: Fraction of the wheels' limits that may be used.

        Returns:
            Rate, rad/s, and acceleration, rad/s^2.
        """
        matrix = (self.allocation @ self.inertia @ self.frame)[:, :2]
        gain = jnp.maximum(jnp.sqrt(jnp.sum(matrix**2, axis=1)), 1e-12)
        load = jnp.sqrt(jnp.sum(self.allocation**2, axis=1) * (momentum @ momentum))
        room = share * jnp.maximum(self.momentum_limit - load, 0.01 * self.momentum_limit)
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
        """Plan a new sweep if one begins; otherwise return the present one.

        Args:
            before: Present or last sweep.
            begin: Whether a sweep begins.
            attitude: Attitude at its start, (4,).
            target: Attitude at its end, including the drift during the sweep, (4,).
            momentum: Total momentum in inertial axes, (3,), N·m·s.
            share: Fraction of the wheels' limits that the sweep may use.
        """
        turn = rotations.product(rotations.conjugate(attitude), target)
        turn = jnp.concatenate([turn[:1], self.frame.T @ turn[1:]])
        limits = self.limits(momentum, share)

        def aim(plan):
            goal, _, number = plan
            sweep = timed(*shortest(goal), *limits)
            drifted = self.drifted(sweep, attitude, momentum)
            goal = rotations.product(rotations.conjugate(drifted), turn)
            return goal, sweep, number + 1

        # no iteration if no sweep begins: in a batch, `cond` would plan for every run and sample
        rounds = jnp.where(begin, AIMS, 0)

        def goes_on(plan):
            # flight code needs a constant bound, and reports if it is reached
            return (plan[2] < rounds) & (plan[2] <= AIMS)

        return jax.lax.while_loop(goes_on, aim, (turn, before, 0))[1]

    def drifted(self, sweep: Sweep, attitude: Quaternion, momentum: Vector3) -> Quaternion:
        """Rotation D by which the drift changes the end of a sweep, in sweep axes at its start.

        A sweep r ends at D r. D' = D (r z) d, with d the drift at the attitude D r, is integrated
        by the midpoint rule.

        Args:
            sweep: Sweep, from its start to its end.
            attitude: Attitude at its start, (4,).
            momentum: Total momentum in inertial axes, (3,), N·m·s.
        """
        step = sweep.duration / NODES
        z = jnp.array([0.0, 0.0, 1.0])

        def growth(turn, time, duration):
            way = turned(sweep, progress(sweep, time)[0])
            quaternion = rotations.product(attitude, self.in_body(rotations.product(turn, way)))
            rate = self.drift @ rotations.to_body(quaternion, momentum)
            return rotations.from_rotation_vector(rate * duration * rotations.to_inertial(way, z))

        def add(k, turn):
            half = rotations.product(turn, growth(turn, k * step, 0.5 * step))
            return rotations.product(turn, growth(half, (k + 0.5) * step, step))

        return jax.lax.fori_loop(0, NODES, add, jnp.array([1.0, 0.0, 0.0, 0.0]))
