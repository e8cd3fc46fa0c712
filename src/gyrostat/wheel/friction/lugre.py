"""LuGre friction: a dynamic model with bristles that deflect before they slip."""

import math
from typing import ClassVar, Self

from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.core.validation import require
from gyrostat.wheel.friction.base import Friction
from gyrostat.wheel.friction.bristles import Bristles
from gyrostat.wheel.friction.stribeck import Stribeck
from gyrostat.wheel.friction.viscous_coulomb import ViscousCoulomb


class LuGre(Bristles):
    """LuGre model dz/dt = w - s_0 abs(w) z / g(w) and F = s_0 z + s_1 dz/dt + b w.

    C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, "A new model for control of systems
    with friction", IEEE Transactions on Automatic Control 40 (1995); Moreira, Lopes and Kuga,
    "Estimation of torque in a reaction wheel using a bristle model for friction", eqs. (1)-(5),
    with the sign of the exponent in (2) corrected. See `Bristles`; any static curve can be given.
    """

    name = "lugre"
    title = "LuGre"
    held_by_default = ("stribeck_speed", "stiffness")
    curve_law: ClassVar[type[Friction]] = Stribeck

    @classmethod
    def from_linear(
        cls,
        *,
        radius: float,
        stiffness: float,
        damping: float,
        viscous: float,
        coulomb: float,
        static: float,
        stribeck_speed: float,
    ) -> Self:
        """Model from forces and speeds at a radius: v = r w, torque = r force, angle = z / r.

        Args:
            radius: Radius r of the sliding surface, m.
            stiffness: Stiffness sigma_0, N/m.
            damping: Damping sigma_1, N·s/m.
            viscous: Viscous coefficient sigma_2, N·s/m.
            coulomb: Coulomb force F_c, N.
            static: Static force F_s, N.
            stribeck_speed: Stribeck speed v_s, m/s.

        Raises:
            InputError: Radius, stiffness, Coulomb force or Stribeck speed is not positive, the
                damping or the viscous coefficient is negative, or F_s is below F_c.
        """
        for name, value in (
            ("radius", radius),
            ("stiffness", stiffness),
            ("coulomb", coulomb),
            ("stribeck_speed", stribeck_speed),
        ):
            require(name, value, positive=True)
        require("damping", damping)
        require("viscous", viscous)
        if not (math.isfinite(static) and static >= coulomb):
            raise InputError(f"static: found {static:g} N, expected at least coulomb {coulomb:g} N")
        curve = Stribeck(
            viscous=viscous * radius**2,
            coulomb=coulomb * radius,
            static=static * radius,
            stribeck_speed=stribeck_speed / radius,
        )
        return cls(curve, stiffness * radius**2, damping * radius**2)

    @classmethod
    def dahl(cls, coulomb: Scalar, stiffness: Scalar) -> Self:
        """Friction model of P. Dahl (1968): constant level, no damping.

        Args:
            coulomb: Coulomb torque, N·m.
            stiffness: Stiffness of the bristles, N·m/rad.
        """
        return cls(ViscousCoulomb(viscous=0.0, coulomb=coulomb), stiffness, 0.0)
