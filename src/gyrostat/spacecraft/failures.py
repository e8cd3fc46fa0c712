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
    """Failure of each wheel: its time and its effects.

    After the failure the motor torque is `torque_share` times the commanded torque plus
    `stuck_torque`, within the momentum limit of the wheel. A seized wheel stops instantly; its
    momentum is transferred to the body.

    Attributes:
        time: Failure times (infinite for wheels without failure), (wheels,), s.
        torque_share: Fraction of the commanded torque that the motor still gives, (wheels,): 0 for
            a lost torque, between 0 and 1 for a degraded motor constant.
        stuck_torque: Motor torque independent of the command, (wheels,), N·m.
        seized: Whether each rotor is fixed to the body, (wheels,).
        added_viscous: Viscous drag added to the bearings, (wheels,), N·m·s/rad.
        sensor_lost: Whether each wheel speed is no longer measured, (wheels,).
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
        zero, no = np.zeros(count), np.zeros(count, dtype=bool)
        return cls(np.full(count, np.inf), np.ones(count), zero, no, zero, no)

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
        """Add the failure of one wheel.

        Args:
            wheel: Index of the wheel, from 0.
            time: Failure time, s.
            torque_share: Remaining fraction of the commanded torque.
            stuck_torque: Constant motor torque, N·m; if not zero, `torque_share` is taken as 0.
            seized: Whether the rotor stops instantly.
            added_viscous: Viscous drag added to the bearing, N·m·s/rad.
            sensor_lost: Whether the wheel speed is no longer measured.

        Returns:
            A copy with this failure.

        Raises:
            InputError: There is no such wheel, or it already has a failure.
        """
        count = len(np.asarray(self.time))
        if wheel not in range(count):
            raise InputError(f"failed wheel: found {wheel}, expected 0 to {count - 1}")
        if np.isfinite(self.time[wheel]):
            raise InputError(
                f"failed wheel: found {wheel}, which fails already at {self.time[wheel]:g} s, "
                "expected one failure per wheel"
            )
        share = 0.0 if stuck_torque or seized else torque_share
        failure = type(self)(time, share, stuck_torque, seized, added_viscous, sensor_lost)
        is_failed = np.arange(count) == wheel
        return jax.tree.map(lambda new, old: np.where(is_failed, new, old), failure, self)

    def torque_lost(self, wheel: int, time: float, *, added_viscous: float = 0.0) -> Self:
        """Add a loss of motor torque; friction and `added_viscous` slow the rotor down."""
        return self.with_failure(wheel, time, torque_share=0.0, added_viscous=added_viscous)

    def seizes(self, wheel: int, time: float) -> Self:
        """Add a seizure: the rotor stops instantly and its momentum is transferred to the body."""
        return self.with_failure(wheel, time, seized=True)

    def failed(self, time: float | Float[Array, ""]) -> Bool[Array, " wheels"]:
        """Whether each wheel has failed at a time, s; (wheels,)."""
        return jnp.asarray(self.time) <= time

    def motor_torque(self, torque: PerWheel, failed: Bool[Array, " wheels"]) -> PerWheel:
        """Motor torques for the commanded `torque`, (wheels,), N·m."""
        share = jnp.where(failed, self.torque_share, 1.0)
        return share * torque + jnp.where(failed, self.stuck_torque, 0.0)
