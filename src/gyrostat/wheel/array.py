"""Array of wheels on one body."""

from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.checked import Checked, limit, positive
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction import Friction, LuGre, ViscousCoulomb

UNIT_TOLERANCE = 1e-6
"""Of the length of an axis: data sheets and drawings round."""

LIMIT_TOLERANCE = 1e-9
"""Of a momentum limit: speeds are converted and rounded."""


def listed(value: Any) -> Any:
    """Lists of numbers as an array; what is none as it is.

    Raises:
        InputError: rows of different lengths, or no numbers.
    """
    if not isinstance(value, list | tuple):
        return value
    try:
        array = jnp.asarray(value)
    except (ValueError, TypeError):
        raise InputError(f"found {value}, expected numbers, in rows of one length") from None
    return array if array.dtype == bool else array.astype(float)


def zeros() -> Any:
    """A field of three components, by default zero."""
    return eqx.field(converter=listed, default_factory=lambda: np.zeros(3))


def _no_friction() -> Friction:
    return ViscousCoulomb(viscous=0.0, coulomb=0.0)


class WheelArray(Checked):
    """Wheels on any axes, commanded in motor torque.

    Attributes:
        axes: (3, wheels) spin axes in body axes, unit length, one column for each wheel.
        inertia: (wheels,) of each rotor about its axis, kg·m².
        torque_limit: (wheels,) largest motor torque, N·m.
        momentum_limit: (wheels,) largest momentum inertia times speed relative to the body, N·m·s:
            there the motor gives no more torque that would speed the wheel up.
        friction: of the bearings, one model whose parameters are (wheels,) or shared.
    """

    axes: Float[Array, "3 wheels"] = eqx.field(converter=listed)
    inertia: Annotated[PerWheel, positive("wheel inertia", "kg·m²")] = eqx.field(converter=listed)
    torque_limit: Annotated[PerWheel | float, limit("wheel torque_limit", "N·m")] = eqx.field(
        converter=listed, default=jnp.inf
    )
    momentum_limit: Annotated[PerWheel | float, limit("wheel momentum_limit", "N·m·s")] = eqx.field(
        converter=listed, default=jnp.inf
    )
    friction: Any = eqx.field(default_factory=_no_friction)

    @property
    def count(self) -> int:
        """Number of wheels."""
        return np.shape(self.axes)[-1]

    def within_torque_limit(self, torque: PerWheel) -> PerWheel:
        """What the motors give of a commanded torque, N·m.

        Raises:
            InputError: not one torque a wheel.
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
        """What of a torque held for `duration`, s, does not speed a wheel up beyond its limit, N·m.

        A wheel already beyond it is not braked. What the turning of the body adds to the speed of a
        wheel, a share of its inertia over the body's, is left out.

        Args:
            torque: (wheels,) N·m.
            momentum: (wheels,) inertia times speed relative to the body, N·m·s.
            duration: s; where it is 0 the result has no effect, but is finite.
        """
        limit = jnp.asarray(self.momentum_limit)
        # 0 / 0 would be NaN for a wheel exactly at its limit
        length = jnp.where(duration > 0.0, duration, 1.0)
        upper = jnp.maximum(limit - momentum, 0.0) / length
        lower = jnp.minimum(-limit - momentum, 0.0) / length
        return jnp.where(jnp.isinf(limit), torque, jnp.clip(torque, lower, upper))

    def check_speed(self, speed: PerWheel) -> None:
        """Refuse speeds relative to the body, (..., wheels), rad/s, beyond the momentum limit.

        Raises:
            InputError: as said.
        """
        limit = np.asarray(self.momentum_limit, dtype=float)
        momentum = np.asarray(self.inertia, dtype=float) * np.asarray(speed, dtype=float)
        # comparisons with NaN are false
        beyond = ~(np.abs(momentum) <= limit * (1.0 + LIMIT_TOLERANCE))
        if np.any(beyond):
            place = tuple(np.argwhere(beyond)[0])
            most = np.broadcast_to(limit, beyond.shape)[place]
            raise InputError(
                f"speed of wheel {place[-1]}: found {np.broadcast_to(speed, beyond.shape)[place]:g}"
                f" rad/s, {momentum[place]:g} N·m·s, expected at most its momentum limit, {most:g} "
                "N·m·s"
            )

    def check_own(self) -> None:
        """Validate axes, friction and shapes.

        Raises:
            InputError: Axes that are not (3, wheels) or not of unit length, friction that is not
                static, parameters of another number of wheels.
        """
        axes = np.asarray(self.axes, dtype=float)
        if axes.ndim < 2 or axes.shape[-2] != 3 or axes.shape[-1] < 1:
            raise InputError(f"wheel axes: found shape {axes.shape}, expected (3, wheels)")
        lengths = np.linalg.norm(axes, axis=-2)
        if not np.all(np.abs(lengths - 1.0) < UNIT_TOLERANCE):
            odd = lengths[~(np.abs(lengths - 1.0) < UNIT_TOLERANCE)].flat[0]
            raise InputError(f"wheel axes: found a length of {odd:g}, expected unit vectors")
        if not isinstance(self.friction, Friction):
            kind = type(self.friction).__name__
            wanted = "a static model" if isinstance(self.friction, LuGre) else "a friction model"
            raise InputError(f"wheel friction: found {kind}, expected {wanted}")
        for name, value in {
            "inertia": self.inertia,
            "torque_limit": self.torque_limit,
            "momentum_limit": self.momentum_limit,
            **self.friction.parameters(),
        }.items():
            # axes before the last are those of runs
            shape = np.shape(value)[axes.ndim - 2 :]
            if shape and shape != (self.count,):
                raise InputError(
                    f"wheel {name}: found {shape[-1]} values, expected {self.count}, one a wheel"
                )
