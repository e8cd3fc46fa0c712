"""Momentum unloading (desaturation) by an external torque."""

from typing import Annotated

import equinox as eqx

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed


class MomentumUnloading(Checked):
    """Unloading torque T = -k H within a limit; the total momentum H decays at the rate k.

    Each body axis is controlled separately, as with ideal magnetorquers. B. Wie, "Space Vehicle
    Dynamics and Control", section 7.5, has the same law with real dipoles.

    Attributes:
        limit: Torque limit along each body axis, (3,), N·m.
        gain: Gain k, 1/s; slow compared with the attitude loop.
    """

    limit: Annotated[Vector3, size("limit of the momentum unloading", "N·m")] = eqx.field(
        converter=listed
    )
    gain: Annotated[Scalar, positive("gain of the momentum unloading", "1/s")] = 1e-3

    def __call__(self, momentum: Vector3, feed_forward: Vector3 | float = 0.0) -> Vector3:
        """Unloading torque in body axes, (3,), N·m.

        Args:
            momentum: Total momentum of spacecraft and wheels in body axes, less the wanted one,
                (3,), N·m·s.
            feed_forward: Torque that brings about the change of the wanted momentum, (3,), N·m.
        """
        limit = jnp.asarray(self.limit)
        return jnp.clip(feed_forward - self.gain * momentum, -limit, limit)
