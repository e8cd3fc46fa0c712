"""Array of wheels on one body."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, limit, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction import AnyFriction, ViscousCoulomb

UNIT_TOLERANCE = 1e-6
"""Largest deviation of the length of an axis from 1; allows for rounded numbers in data sheets."""

LIMIT_TOLERANCE = 1e-9
"""Relative tolerance of a momentum limit; allows for rounding in converted speeds."""


def listed(value: Any) -> Any:
    """Convert lists of numbers to arrays; return other values unchanged.

    Raises:
        InputError: The rows have different lengths, or a value is not a number.
    """
    if not isinstance(value, list | tuple):
        return value
    try:
        array = jnp.asarray(value)
    except (ValueError, TypeError):
        raise InputError(f"found {value}, expected numbers, in rows of one length") from None
    return array if array.dtype == bool else array.astype(float)


def zeros() -> Any:
    """Dataclass field of three components, zero by default."""
    return eqx.field(converter=listed, default_factory=lambda: np.zeros(3))


class WheelArray(Checked):
    """Wheels on any axes, commanded by motor torque.

    Attributes:
        axes: Spin axes in body axes, unit length, one column for each wheel, (3, wheels).
        inertia: Inertia of each rotor about its axis, (wheels,), kg·m².
        torque_limit: Largest motor torque, (wheels,), N·m.
        momentum_limit: Largest momentum, inertia times speed relative to the body, (wheels,),
            N·m·s. At this limit, the motor gives no torque that would increase the speed.
        friction: Bearing friction, a static `Friction` or `LuGre`, one model whose parameters are
            (wheels,) or shared.
    """

    axes: Float[Array, "3 wheels"] = eqx.field(converter=listed)
    inertia: Annotated[PerWheel, positive("wheel inertia", "kg·m²")] = eqx.field(converter=listed)
    torque_limit: Annotated[PerWheel | float, limit("wheel torque_limit", "N·m")] = eqx.field(
        converter=listed, default=jnp.inf
    )
    momentum_limit: Annotated[PerWheel | float, limit("wheel momentum_limit", "N·m·s")] = eqx.field(
        converter=listed, default=jnp.inf
    )
    friction: Any = eqx.field(default_factory=lambda: ViscousCoulomb(viscous=0.0, coulomb=0.0))

    @property
    def count(self) -> int:
        """Number of wheels."""
        return np.shape(self.axes)[-1]

    def within_torque_limit(self, torque: PerWheel) -> PerWheel:
        """Commanded torques limited to the torque limits of the motors, (wheels,), N·m.

        Raises:
            InputError: There is not one torque for each wheel.
        """
        if np.shape(torque) != (self.count,):
            raise InputError(
                f"wheel torque: found shape {np.shape(torque)}, expected ({self.count},)"
            )
        limit = jnp.asarray(self.torque_limit)
        return jnp.clip(torque, -limit, limit)

    def within_momentum_limit(
        self, torque: PerWheel, momentum: PerWheel, duration: Scalar
    ) -> PerWheel:
        """Torques limited so that no wheel speeds up beyond its momentum limit, (wheels,), N·m.

        A wheel that is already beyond its limit is not braked. The effect of the changing body rate
        on the wheel speed is neglected; it is of the order of wheel inertia over body inertia.

        Args:
            torque: Torques, held over `duration`, (wheels,), N·m.
            momentum: Inertia times speed relative to the body, (wheels,), N·m·s.
            duration: Duration of the torques, s. If it is 0, the result is finite but has no
                effect.
        """
        limit = jnp.asarray(self.momentum_limit)
        # 0 / 0 would be NaN for a wheel exactly at its limit
        length = jnp.where(duration > 0.0, duration, 1.0)
        upper = jnp.maximum(limit - momentum, 0.0) / length
        lower = jnp.minimum(-limit - momentum, 0.0) / length
        return jnp.where(jnp.isinf(limit), torque, jnp.clip(torque, lower, upper))

    def check_speed(self, speed: PerWheel) -> None:
        """Check that wheel speeds are within the momentum limit.

        Args:
            speed: Speeds relative to the body, (..., wheels), rad/s.

        Raises:
            InputError: A speed is beyond the momentum limit.
        """
        limit = np.asarray(self.momentum_limit, dtype=float)
        momentum = np.asarray(self.inertia, dtype=float) * np.asarray(speed, dtype=float)
        # comparisons with NaN are false
        excess = ~(np.abs(momentum) <= limit * (1.0 + LIMIT_TOLERANCE))
        if np.any(excess):
            index = tuple(np.argwhere(excess)[0])
            largest = np.broadcast_to(limit, excess.shape)[index]
            raise InputError(
                f"speed of wheel {index[-1]}: found {np.broadcast_to(speed, excess.shape)[index]:g}"
                f" rad/s, {momentum[index]:g} N·m·s, expected at most its momentum limit, "
                f"{largest:g} N·m·s"
            )

    def check_own(self) -> None:
        """Validate axes, friction and shapes.

        Raises:
            InputError: The axes are not (3, wheels) or not of unit length, the friction is no
                friction model, or a parameter has another number of wheels.
        """
        axes = np.asarray(self.axes, dtype=float)
        if axes.ndim < 2 or axes.shape[-2] != 3 or axes.shape[-1] < 1:
            raise InputError(f"wheel axes: found shape {axes.shape}, expected (3, wheels)")
        lengths = np.linalg.norm(axes, axis=-2)
        if not np.all(np.abs(lengths - 1.0) < UNIT_TOLERANCE):
            odd = lengths[~(np.abs(lengths - 1.0) < UNIT_TOLERANCE)].flat[0]
            raise InputError(f"wheel axes: found a length of {odd:g}, expected unit vectors")
        if not isinstance(self.friction, AnyFriction):
            kind = type(self.friction).__name__
            raise InputError(f"wheel friction: found {kind}, expected a friction model")
        for name, value in {
            "inertia": self.inertia,
            "torque_limit": self.torque_limit,
            "momentum_limit": self.momentum_limit,
            **self.friction.parameters(),
        }.items():
            # axes before the last are batch axes
            shape = np.shape(value)[axes.ndim - 2 :]
            if shape and shape != (self.count,):
                raise InputError(
                    f"wheel {name}: found {shape[-1]} values, expected {self.count}, one per wheel"
                )
