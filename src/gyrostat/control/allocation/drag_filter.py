"""Low-pass filter of the torque lost by rotors, through bearing drag or a failing motor."""

from typing import Any

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jnp


def lost_torque(memory: Any, momentum: PerWheel, period: Scalar) -> PerWheel:
    """Commanded torque that did not change the momentum of the rotors since the last sample, N·m.

    Args:
        memory: Memory with `torque`, (delay + 1, wheels), N·m, the torques commanded at the last
            samples, the oldest first, and `momentum`, (wheels,), N·m·s, at the last sample.
        momentum: Momentum of the rotors, inertia times their inertial speed, (wheels,), N·m·s.
        period: Time since the last sample, s.
    """
    return memory.torque[0] - (momentum - memory.momentum) / period


def low_passed(mean: PerWheel, lost: PerWheel, time: Scalar, period: Scalar, used: Any) -> PerWheel:
    """Filtered lost torque after a sample, N·m.

    Args:
        mean: Filtered lost torque before the sample, (wheels,), N·m.
        lost: Lost torque at the sample, (wheels,), N·m, see `lost_torque`.
        time: Time constant, s.
        period: Time since the last sample, s.
        used: Whether the sample is used, (wheels,) or one for all.
    """
    share = period / (time + period)
    return mean + share * jnp.where(used, lost - mean, 0.0)
