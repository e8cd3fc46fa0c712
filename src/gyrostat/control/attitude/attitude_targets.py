"""Target attitude over time, piecewise constant."""

from typing import Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.core import rotations
from gyrostat.core.arrays import Quaternion, Scalar
from gyrostat.core.checked import Checked
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.array import listed


class AttitudeTargets(Checked):
    """Target attitude over time, piecewise constant.

    The targets define where to point but no rate, and a law takes each for a target at rest.
    Targets that move at a constant rate W are therefore followed with a constant lag, for
    `WheelArrayControl` of W (1 / k + 1 / k_t) rad, as derived there. For a target that moves, use
    `gyrostat.control.guidance.Guided`.

    Attributes:
        times: Start times of the targets, (targets,), increasing, s. The first target also applies
            before its time.
        attitudes: Target quaternions, scalar first, (targets, 4).
    """

    times: Float[Array, " targets"] = eqx.field(converter=listed)
    attitudes: Float[Array, "targets 4"] = eqx.field(converter=listed)

    @classmethod
    def hold(cls, attitude: ArrayLike) -> Self:
        """Constant target attitude."""
        return cls(jnp.zeros(1), jnp.asarray(attitude, dtype=float)[None])

    def check_own(self) -> None:
        """Validate times and attitudes.

        Raises:
            InputError: The times are missing, not finite or not increasing; or the attitudes have
                the wrong shape or are not of unit length.
        """
        times = np.asarray(self.times, dtype=float)
        rising = times.size > 0 and times.ndim > 0 and np.all(np.isfinite(times))
        if not rising or not np.all(np.diff(times, axis=-1) > 0.0):
            raise InputError(f"times of the targets: found {times}, expected increasing times, s")
        shape = np.shape(self.attitudes)
        if shape != (*times.shape, 4):
            raise InputError(f"targets: found shape {shape}, expected {(*times.shape, 4)}")
        rotations.check_unit(self.attitudes)

    def __call__(self, time: Scalar) -> Quaternion:
        """Target attitude at a time, s."""
        # multiples of a control period are subject to rounding
        count = jnp.sum(jnp.asarray(self.times) <= time + 1e-9)
        return jnp.asarray(self.attitudes)[jnp.maximum(count - 1, 0)]
