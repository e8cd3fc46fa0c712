"""Stribeck friction with different parameters for the two directions of rotation."""

from collections.abc import Mapping
from typing import ClassVar, Self

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.wheel.friction.base import Friction, parameter
from gyrostat.wheel.friction.stribeck import DEFAULT_STRIBECK_SPEED, stribeck_torque


class DirectionalStribeck(Friction):
    """Stribeck friction with its own b, c and T_s for positive and for negative speed.

    Bearings can be asymmetric (Canudas de Wit and Åström 1987, cited by Carrara and Kuga, whose
    model is symmetric). The Stribeck speed, which can rarely be observed, is the same for both
    directions.
    """

    name: ClassVar[str] = "directional"
    title: ClassVar[str] = "direction-dependent Stribeck"
    held_by_default: ClassVar[tuple[str, ...]] = ("stribeck_speed",)
    vanishing_at: ClassVar[Mapping[str, str]] = {
        "static_positive": "coulomb_positive",
        "static_negative": "coulomb_negative",
    }
    odd: ClassVar[bool] = False

    viscous_positive: Scalar = parameter("viscous")
    viscous_negative: Scalar = parameter("viscous")
    coulomb_positive: Scalar = parameter("torque")
    coulomb_negative: Scalar = parameter("torque")
    static_positive: Scalar = parameter("torque")
    static_negative: Scalar = parameter("torque")
    stribeck_speed: Scalar = parameter("speed")

    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.torque`."""
        forward = direction > 0
        return stribeck_torque(
            speed,
            direction,
            jnp.where(forward, self.viscous_positive, self.viscous_negative),
            jnp.where(forward, self.coulomb_positive, self.coulomb_negative),
            jnp.where(forward, self.static_positive, self.static_negative),
            self.stribeck_speed,
        )

    def viscous_torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.viscous_torque`."""
        return jnp.where(direction > 0, self.viscous_positive, self.viscous_negative) * speed

    @classmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """See `Friction.from_coulomb`."""
        return cls.of(
            viscous_positive=viscous,
            viscous_negative=viscous,
            coulomb_positive=coulomb,
            coulomb_negative=coulomb,
            static_positive=coulomb,
            static_negative=coulomb,
            stribeck_speed=DEFAULT_STRIBECK_SPEED,
        )
