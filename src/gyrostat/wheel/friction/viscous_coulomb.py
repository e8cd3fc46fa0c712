"""Viscous plus Coulomb friction."""

from typing import ClassVar, Self

from gyrostat.core.arrays import Scalar
from gyrostat.wheel.friction.base import Friction, parameter


class ViscousCoulomb(Friction):
    """F(w) = b w + sgn(w) c.

    Carrara and Kuga, "Estimating friction parameters in reaction wheels for attitude control",
    eq. (1) with d = 0: the model of their deterministic methods.
    """

    name: ClassVar[str] = "viscous-coulomb"
    title: ClassVar[str] = "viscous + Coulomb"

    viscous: Scalar = parameter("viscous")
    coulomb: Scalar = parameter("torque")

    def torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.torque`."""
        return self.viscous * speed + direction * self.coulomb

    def viscous_torque(self, speed: Scalar, direction: Scalar) -> Scalar:
        """See `Friction.viscous_torque`."""
        return self.viscous * speed

    @classmethod
    def from_coulomb(cls, viscous: float, coulomb: float) -> Self:
        """See `Friction.from_coulomb`."""
        return cls.of(viscous=viscous, coulomb=coulomb)
