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

    Attributes:
        time: Start of each entry, (entries,), increasing, s.
        unloads: Time from there in which the external actuator works, (entries,), s.
        momentum: Total momentum at its end, inertial axes, (entries, 3), N·m·s.
        null_space: Null-space momentum z, (entries,), N·m·s.
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

    def level(self, time: Scalar) -> Scalar:
        """Null-space momentum z at a time, s, in N·m·s."""
        return jnp.asarray(self.null_space)[self._number(time)]

    def torque(
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
        goal = rotations.to_body(attitude, jnp.asarray(self.momentum)[number])
        since = time - jnp.asarray(self.time)[number]
        # tolerance, because a multiple of the control period has a rounding error
        acts = (since > -1e-9) & (since < jnp.asarray(self.unloads)[number] - 1e-9)
        return jnp.where(acts, unloading(momentum - goal), 0.0)

    def _number(self, time: Scalar) -> Scalar:
        return jnp.maximum(jnp.sum(jnp.asarray(self.time) <= time + 1e-9) - 1, 0)
