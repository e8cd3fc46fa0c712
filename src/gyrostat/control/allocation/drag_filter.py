"""Low pass of the torque that rotors lose: drag of their bearings, or a motor that fails."""

from typing import Any

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jnp


def lost_torque(memory: Any, momentum: PerWheel, period: Scalar) -> PerWheel:
    """Commanded torque that the rotors did not take up since the last sample, N·m.

    Args:
        memory: has `torque` (delay + 1, wheels), N·m, commanded at the last samples, the oldest
            first, and `momentum` (wheels,) at the last sample, N·m·s.
        momentum: (wheels,) of the rotors, inertia times their speed in space, N·m·s.
        period: since the last sample, s.
    """
    return memory.torque[0] - (momentum - memory.momentum) / period


def low_passed(mean: PerWheel, lost: PerWheel, time: Scalar, period: Scalar, used: Any) -> PerWheel:
    """Mean of the lost torque after a sample, N·m.

    Args:
        mean: (wheels,) before, N·m.
        lost: (wheels,) see `lost_torque`.
        time: Time constant, s.
        period: since the last sample, s.
        used: whether the sample counts, (wheels,) or one for all.
    """
    share = period / (time + period)
    return mean + share * jnp.where(used, lost - mean, 0.0)
