"""Stribeck friction: the torque falls from the static to the Coulomb level as the speed grows."""

from collections.abc import Mapping
from typing import ClassVar, Self

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction.base import Friction, parameter

DEFAULT_STRIBECK_SPEED = 0.418879
"""Stribeck speed of Carrara and Kuga (4 rpm), rad/s, for records that cannot determine it."""


def stribeck_torque(
    speed: Scalar,
    direction: Scalar,
    viscous: Scalar,
    coulomb: Scalar,
    static: Scalar,
    stribeck_speed: Scalar,
) -> Scalar:
    """F(w) = b w + sgn(w) [c + (T_s - c) exp(-w^2 / w_s^2)], N·m, for a fixed direction.

    Carrara and Kuga, eq. (1).
    """
    excess = (static - coulomb) * jnp.exp(-((speed / stribeck_speed) ** 2))
    return viscous * speed + direction * (coulomb + excess)


class Stribeck(Friction):
    """F(w) = b w + sgn(w) [c + (T_s - c) exp(-w^2 / w_s^2)].

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control", eq.
    (1), with d = T_s - c. The curve jumps by 2 T_s at zero speed, where the wheel sticks.
    """

    name: ClassVar[str] = "stribeck"
    title: ClassVar[str] = "Stribeck"
    held_by_default: ClassVar[tuple[str, ...]] = ("stribeck_speed",)
    vanishing_at: ClassVar[Mapping[str, str]] = {"static": "coulomb"}

    viscous: Scalar = parameter("viscous")
    coulomb: Scalar = parameter("torque")
    static: Scalar = parameter("torque")
    stribeck_speed: Scalar = parameter("speed")

    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.torque`."""
        return stribeck_torque(
            speed, direction, self.viscous, self.coulomb, self.static, self.stribeck_speed
        )

    def breakaway_torque(self, direction: Scalar) -> Scalar:
        """Static torque; see `Friction.breakaway_torque`."""
        # shorter and faster in flight code than the curve at zero speed
        return jnp.broadcast_arrays(jnp.asarray(self.static), jnp.asarray(direction))[0]

    def viscous_torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.viscous_torque`."""
        return self.viscous * speed

    @classmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """See `Friction.from_coulomb`."""
        return cls.of(
            viscous=viscous, coulomb=coulomb, static=coulomb, stribeck_speed=DEFAULT_STRIBECK_SPEED
        )
