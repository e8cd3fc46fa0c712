"""Largest rate and acceleration of a slew within the torque and momentum of the working wheels."""

from functools import partial
from typing import Annotated, Any, NamedTuple, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.control.allocation.working_wheels import SPAN
from gyrostat.control.guidance.slew_profile import NO_LIMIT
from gyrostat.core import rotations
from gyrostat.core.arrays import PerWheel, Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, positive_share
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel.array import listed, zeros

SLOWEST = 1e-4
"""Smallest rate limit, rad/s: a slew goes on even if the wheels seem to have no momentum left."""
SMALL = 1e-12
"""Smallest divisor of torques, momenta and rates."""


class WheelRoom(NamedTuple):
    """Wheels that a slew may use, at its start.

    Attributes:
        rows: Pseudo-inverse of the axes of the working wheels, (wheels, 3).
        inertia: Inertia without the spin inertia of the rotors, (3, 3), kg·m².
        locked: Inertia with it, (3, 3), kg·m².
        torque: Torque for slews, (wheels,), N·m.
        momentum: Momentum for slews, (wheels,), N·m·s.
        null: Momentum of the wheels that cancels on the body, (wheels,), N·m·s.
        total: Total momentum in inertial axes, (3,), N·m·s.
    """

    rows: Float[Array, "wheels 3"]
    inertia: Float[Array, "3 3"]
    locked: Float[Array, "3 3"]
    torque: Float[Array, " wheels"]
    momentum: Float[Array, " wheels"]
    null: Float[Array, " wheels"]
    total: Vector3


class WheelEnvelope(Checked):
    """Torque and momentum that the wheels can give to an eigenaxis slew.

    With the total momentum H, constant in inertial axes, the wheels take up the torque A u = -w x H
    - J w' and hold the momentum A h = H - J w. In a slew about the axis a, w = a s' and H turns
    about a in body axes. Each wheel gets its share by the pseudo-inverse of the axes; the momentum
    in the null space stays as it is. Every torque and momentum is the largest over the angles that
    the slew passes.

    Attributes:
        spacecraft: Spacecraft model of the controller.
        share: Pseudo-inverse of the working axes, (sets, wheels, 3), one for each set of working
            wheels.
        works: Whether each wheel works, 0 or 1, (sets, wheels).
        starts: Time from which each set applies, (sets,), increasing from 0, s.
        total_momentum: Total momentum in inertial axes, (3,), N·m·s.
        wheel_momentum: Momentum of the wheels relative to the body before the slew, (wheels,),
            N·m·s. Only its part that cancels on the body is used.
        torque_share: Fraction of the torque limits for slews; the rest is for feedback and
            friction.
        momentum_share: Fraction of the momentum limits for slews.
    """

    spacecraft: Spacecraft
    share: Float[Array, "sets wheels 3"]
    works: Float[Array, "sets wheels"]
    starts: Float[Array, " sets"] = eqx.field(converter=listed, default_factory=lambda: np.zeros(1))
    total_momentum: Vector3 = zeros()
    wheel_momentum: PerWheel | float = 0.0
    torque_share: Annotated[Scalar, positive_share("torque share of slews")] = 0.8
    momentum_share: Annotated[Scalar, positive_share("momentum share of slews")] = 0.9

    @classmethod
    def of(cls, spacecraft: Spacecraft, working: ArrayLike | None = None, **others: Any) -> Self:
        """Envelope of a spacecraft; computed once, outside the loop.

        Args:
            spacecraft: Spacecraft model of the controller.
            working: Whether each wheel works, (wheels,), or (sets, wheels) for several sets; None:
                all wheels.
            others: Other attributes.

        Raises:
            InputError: The axes of a set of working wheels do not span space.
        """
        axes = np.asarray(spacecraft.wheels.axes, dtype=float)
        sets = np.atleast_2d(np.ones(axes.shape[1], bool) if working is None else working)
        for each in sets:
            if np.linalg.matrix_rank(axes * each, tol=SPAN) < 3:
                raise InputError(
                    "slews: found working wheels that do not span space, expected them to"
                )
        share = [np.linalg.pinv(axes * each, rcond=SPAN) for each in sets]
        works = jnp.asarray(sets, dtype=float)
        return cls(spacecraft, jnp.asarray(np.array(share)), works, **others)

    def room(self, time: Scalar) -> WheelRoom:
        """Wheels that a slew may use.

        Args:
            time: Time of its start, s.
        """
        number = jnp.sum(jnp.asarray(self.starts) <= time + 1e-9) - 1
        rows, wheels = jnp.asarray(self.share)[number], self.spacecraft.wheels
        held = jnp.asarray(self.works)[number] * self.wheel_momentum
        return WheelRoom(
            rows,
            jnp.asarray(self.spacecraft.inertia),
            jnp.asarray(self.spacecraft.inertia_locked()),
            self.torque_share * jnp.minimum(wheels.torque_limit, NO_LIMIT),
            self.momentum_share * jnp.minimum(wheels.momentum_limit, NO_LIMIT),
            held - rows @ (jnp.asarray(wheels.axes) @ held),
            jnp.asarray(self.total_momentum, dtype=float),
        )

    def limits(
        self,
        turn: Vector3,
        attitude: Quaternion,
        time: Scalar,
        rate: Scalar = np.inf,
        acceleration: Scalar = np.inf,
    ) -> tuple[Scalar, Scalar]:
        """Rate and acceleration with the shortest time of a slew without jerk limit.

        With a rate s, wheel i has the acceleration a_i (1 - c_i s) left: turning the momentum takes
        the share c_i s of its torque. The slew takes angle / s + s / a(s) with the least a(s) of
        all wheels. This function of s is a maximum of convex functions, so that its minimum is that
        of one of them, or lies where two are equal, or at the largest rate.

        Args:
            turn: Rotation vector of the slew in body axes, (3,), rad.
            attitude: Attitude at its start, (4,).
            time: Time of its start, s.
            rate: Further limit of the rate, rad/s.
            acceleration: Further limit of the acceleration, rad/s².

        Returns:
            Rate, rad/s, and acceleration, rad/s².
        """
        angle = jnp.sqrt(turn @ turn)
        axis = jnp.where(angle > SMALL, turn / jnp.where(angle > SMALL, angle, 1.0), jnp.eye(3)[0])
        room = self.room(time)
        rows, torque = room.rows, room.torque
        total = rotations.to_body(attitude, room.total)
        along = axis * (axis @ total)
        across, normal = total - along, jnp.cross(axis, total)

        def largest(constant: PerWheel, cosine: PerWheel, sine: PerWheel) -> PerWheel:
            """Largest |constant + cosine cos(x) + sine sin(x)| for x from 0 to the angle."""
            turning = jnp.arctan2(sine, cosine)
            # modulo pi, without fmod: in flight code it makes a pass for each digit of a quotient
            within = jnp.where(turning < jnp.pi, turning, 0.0)
            turning = jnp.where(turning < 0.0, turning + jnp.pi, within)
            places = jnp.stack([0.0 * turning, angle + 0.0 * turning, jnp.minimum(turning, angle)])
            values = constant + cosine * jnp.cos(places) + sine * jnp.sin(places)
            return jnp.max(jnp.abs(values), axis=0)

        # in body axes the momentum is along + across cos(x) - beside sin(x)
        gyroscopic = largest(jnp.zeros(len(rows)), rows @ normal, rows @ across)
        inertial = jnp.maximum(jnp.abs(rows @ (room.inertia @ axis)), SMALL)
        at_rest = largest(room.null + rows @ along, rows @ across, -rows @ normal)
        spun = jnp.maximum(jnp.abs(rows @ (room.locked @ axis)), SMALL)
        free = jnp.min(jnp.maximum(room.momentum - at_rest, 0.0) / spun)
        fastest = jnp.minimum(rate, jnp.maximum(free, SLOWEST))
        quickest = jnp.append(torque / inertial, jnp.minimum(acceleration, NO_LIMIT))
        load = jnp.append(gyroscopic / jnp.maximum(torque, SMALL), 0.0)

        def acceleration_at(rate: Any) -> Any:
            return jnp.min(quickest * (1.0 - load * rate[..., None]), axis=-1)

        square = jnp.sqrt(quickest * angle)
        first, second = np.triu_indices(len(rows) + 1, 1)
        slope = (quickest * load)[first] - (quickest * load)[second]
        crossing = (quickest[first] - quickest[second]) / jnp.where(slope == 0.0, 1.0, slope)
        rates = jnp.concatenate([square / (1.0 + load * square), crossing, fastest[None]])
        rates = jnp.clip(rates, SMALL, fastest)
        least = acceleration_at(rates)
        times = jnp.where(least > 0.0, angle / rates + rates / jnp.maximum(least, SMALL), jnp.inf)

        def quickest_of(best: Any, each: Any) -> tuple[Any, None]:
            return jax.tree.map(partial(jnp.where, each[0] < best[0]), each, best), None

        # not by argmin, which has tests for NaN in flight code
        (_, optimum), _ = jax.lax.scan(quickest_of, (jnp.array(jnp.inf), rates[0]), (times, rates))
        return optimum, jnp.maximum(acceleration_at(optimum), SMALL)
