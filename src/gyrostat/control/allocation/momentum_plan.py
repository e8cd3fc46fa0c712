"""Planned momentum of the wheels over time: total momentum and null-space momentum."""

from typing import Annotated

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.control.allocation.momentum_unloading import MomentumUnloading
from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar, Vector3
from gyrostat.core.checked import Checked, signed, size
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed

Times = Float[Array, " entries"]


class MomentumPlan(Checked):
    """Plan whose entries each hold from their time until the next; the first holds before it too.

    An entry gives the null-space momentum z of `NullSpaceControl` that the wheels are to have, and
    the total momentum that the external actuator brings about within the first `unloads` seconds of
    the entry. At other times the actuator is off, so that it does not move wheel speeds while they
    matter.

    In these seconds the wanted total momentum H_d is a straight line that ends at `momentum`. The
    torque of the actuator is `torque` - k (H - H_d). `torque` is the feed-forward: the rate of H_d
    less the external torques that the plan expects. Without it, H stays behind H_d by the external
    torque over k.

    Attributes:
        time: Start of each entry, (entries,), increasing, s.
        unloads: Time from there in which the external actuator works, (entries,), s.
        momentum: Total momentum at its end, inertial axes, (entries, 3), N·m·s.
        null_space: Null-space momentum z, (entries,), N·m·s.
        momentum_rate: Rate of the wanted total momentum, inertial axes, (entries, 3), N·m.
        torque: Feed-forward torque of the actuator, inertial axes, (entries, 3), N·m.
    """

    time: Annotated[Times, size("time of the momentum plan", "s")] = eqx.field(converter=listed)
    unloads: Annotated[Times, size("unloading time of the momentum plan", "s")] = eqx.field(
        converter=listed
    )
    momentum: Annotated[
        Float[Array, "entries 3"], signed("size of the planned momentum", "N·m·s")
    ] = eqx.field(converter=listed)
    null_space: Annotated[Times, signed("size of the planned null-space momentum", "N·m·s")] = (
        eqx.field(converter=listed)
    )
    momentum_rate: Annotated[
        Float[Array, "entries 3"], signed("size of the planned rate of momentum", "N·m")
    ] = eqx.field(converter=listed)
    torque: Annotated[Float[Array, "entries 3"], signed("size of the planned torque", "N·m")] = (
        eqx.field(converter=listed)
    )

    def level(self, time: Scalar) -> Scalar:
        """Null-space momentum z at a time, s, in N·m·s."""
        return jnp.asarray(self.null_space)[self._number(time)]

    def unload(
        self, unloading: MomentumUnloading, time: Scalar, attitude: Quaternion, momentum: Vector3
    ) -> Vector3:
        """Torque of the external actuator in body axes, (3,), N·m.

        Args:
            unloading: Law of the external actuator.
            time: Time, s.
            attitude: Attitude, (4,), scalar first.
            momentum: Total momentum in body axes, (3,), N·m·s.
        """
        number = self._number(time)
        since = time - jnp.asarray(self.time)[number]
        left = jnp.asarray(self.unloads)[number] - since
        goal = jnp.asarray(self.momentum)[number] - left * jnp.asarray(self.momentum_rate)[number]
        goal, feed_forward = (
            rotations.to_body(attitude, each) for each in (goal, jnp.asarray(self.torque)[number])
        )
        # tolerance, because a multiple of the control period has a rounding error
        acts = (since > -1e-9) & (left > 1e-9)
        return jnp.where(acts, unloading(momentum - goal, feed_forward), 0.0)

    def _number(self, time: Scalar) -> Scalar:
        return jnp.maximum(jnp.sum(jnp.asarray(self.time) <= time + 1e-9) - 1, 0)
