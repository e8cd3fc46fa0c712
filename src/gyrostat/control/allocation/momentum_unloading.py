"""Momentum unloading (desaturation) by an external torque."""

import equinox as eqx
import numpy as np

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import require
from gyrostat.wheel.array import listed


class MomentumManagement(eqx.Module):
    """T = -k H within the limit: the momentum of the whole spacecraft fades with k.

    Along every body axis for itself, as an ideal set of magnetorquers would. B. Wie, "Space Vehicle
    Dynamics and Control", section 7.5, has the same with real dipoles.

    Attributes:
        limit: (3,) along each body axis, N·m.
        gain: k, 1/s; slow against the attitude loop.
    """

    limit: Vector3 = eqx.field(converter=listed)
    gain: Scalar = 1e-3

    def check(self) -> None:
        """Refuse a limit or gain that is no size, by `InputError`."""
        require("limit of the momentum management", self.limit, "N·m")
        require("gain of the momentum management", np.asarray(self.gain), "1/s", positive=True)

    def __call__(self, momentum: Vector3) -> Vector3:
        """The torque, in body axes, N·m.

        Args:
            momentum: (3,) of spacecraft and wheels, in body axes, N·m·s.
        """
        limit = jnp.asarray(self.limit)
        return jnp.clip(-self.gain * momentum, -limit, limit)
