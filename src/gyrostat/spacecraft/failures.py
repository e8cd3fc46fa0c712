"""Wheel failures during a run."""

from typing import Annotated, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Bool, Float

from gyrostat.core.arrays import PerWheel
from gyrostat.core.checked import Checked, finite, from_start, share, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.wheel.array import listed


class WheelFailures(Checked):
    """What happens to each wheel, and when; a wheel without failure has an infinite time.

    From its time on the motor torque of a wheel is `torque_share` of the commanded one plus
    `stuck_torque`, within the momentum limit of the wheel. A seized wheel stops at once and its
    momentum goes to the body.

    Attributes:
        time: (wheels,) of the failure, s.
        torque_share: (wheels,) of the commanded torque that the motor still gives: 0 when its
            torque is lost, between 0 and 1 when its motor constant is degraded.
        stuck_torque: (wheels,) that the motor gives whatever is commanded, N·m.
        seized: (wheels,) whether the rotor is fixed to the body.
        added_viscous: (wheels,) drag added to the bearing, N·m·s/rad.
        sensor_lost: (wheels,) whether the speed is no longer measured.
    """

    time: Annotated[PerWheel, from_start("failure time")] = eqx.field(converter=listed)
    torque_share: Annotated[PerWheel, share("torque share of a failed wheel")] = eqx.field(
        converter=listed
    )
    stuck_torque: Annotated[PerWheel, finite("stuck torque", "N·m")] = eqx.field(converter=listed)
    seized: Bool[Array, " wheels"] = eqx.field(converter=listed)
    added_viscous: Annotated[PerWheel, size("drag added by a failure", "N·m·s/rad")] = eqx.field(
        converter=listed
    )
    sensor_lost: Bool[Array, " wheels"] = eqx.field(converter=listed)

    @classmethod
    def none(cls, count: int) -> Self:
        """No failure of any of `count` wheels."""
        zero, no = jnp.zeros(count), jnp.zeros(count, dtype=bool)
        return cls(jnp.full(count, jnp.inf), jnp.ones(count), zero, no, zero, no)

    def with_failure(
        self,
        wheel: int,
        time: float,
        *,
        torque_share: float = 1.0,
        stuck_torque: float = 0.0,
        seized: bool = False,
        added_viscous: float = 0.0,
        sensor_lost: bool = False,
    ) -> Self:
        """The same, and one wheel that fails as said.

        Args:
            wheel: its number, from 0.
            time: s.
            torque_share: see the class; so are the others.
            stuck_torque: N·m; the commanded torque then counts as lost.
            seized: the rotor stops at once.
            added_viscous: N·m·s/rad.
            sensor_lost: no more measurements of its speed.

        Raises:
            InputError: there is no such wheel, or it fails already.
        """
        count = len(np.asarray(self.time))
        if wheel not in range(count):
            raise InputError(f"failed wheel: found {wheel}, expected 0 to {count - 1}")
        if np.isfinite(self.time[wheel]):
            raise InputError(
                f"failed wheel: found {wheel}, which fails already at {self.time[wheel]:g} s, "
                "expected one failure a wheel"
            )
        share = 0.0 if stuck_torque or seized else torque_share
        failure = type(self)(time, share, stuck_torque, seized, added_viscous, sensor_lost)
        own = jnp.arange(count) == wheel
        return jax.tree.map(lambda new, old: jnp.where(own, new, old), failure, self)

    def torque_lost(self, wheel: int, time: float, *, added_viscous: float = 0.0) -> Self:
        """A motor without torque: the rotor runs down by its own friction and `added_viscous`."""
        return self.with_failure(wheel, time, torque_share=0.0, added_viscous=added_viscous)

    def seizes(self, wheel: int, time: float) -> Self:
        """A rotor that stops at once and gives its momentum to the body."""
        return self.with_failure(wheel, time, seized=True)

    def failed(self, time: float | Float[Array, ""]) -> Bool[Array, " wheels"]:
        """Which failures have happened at a time, s."""
        return jnp.asarray(self.time) <= time

    def motor_torque(self, torque: PerWheel, failed: Bool[Array, " wheels"]) -> PerWheel:
        """What the motors give where `torque` is commanded, N·m."""
        share = jnp.where(failed, self.torque_share, 1.0)
        return share * torque + jnp.where(failed, self.stuck_torque, 0.0)
