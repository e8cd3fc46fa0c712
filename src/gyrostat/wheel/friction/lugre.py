"""LuGre friction: bristles that bend before they slip, so that friction remembers."""

import math
from typing import Annotated, Self

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import require
from gyrostat.wheel.friction.base import Friction
from gyrostat.wheel.friction.stribeck import Stribeck
from gyrostat.wheel.friction.viscous_coulomb import ViscousCoulomb


class LuGre(Checked):
    """dz/dt = w - s_0 abs(w) z / g(w) and F = s_0 z + s_1 dz/dt + b w.

    C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, "A new model for control of systems
    with friction", IEEE Transactions on Automatic Control 40 (1995); Moreira, Lopes and Kuga,
    "Estimation of torque in a reaction wheel using a bristle model for friction", eqs. (1)-(5),
    with the sign of the exponent in (2) corrected. Rotary: z is an angle, g a torque, the level of
    a static friction curve without its viscous part. In steady rotation F is that curve.

    Attributes:
        curve: static friction curve, which gives g and the viscous part.
        stiffness: s_0 of the bristles, N·m/rad.
        damping: s_1 of the bristles, N·m·s/rad.
    """

    curve: Friction
    stiffness: Annotated[Scalar, positive("bristle stiffness", "N·m/rad")]
    damping: Annotated[Scalar, size("bristle damping", "N·m·s/rad")]

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
        """Build from forces and speeds at a radius: v = r w, torque = r force, z / r an angle.

        Args:
            radius: r of the sliding surface, m.
            stiffness: sigma_0, N/m.
            damping: sigma_1, N·s/m.
            viscous: sigma_2, N·s/m.
            coulomb: F_c, N.
            static: F_s, N.
            stribeck_speed: v_s, m/s.

        Raises:
            InputError: a radius, stiffness, force or Stribeck speed that is not positive, a
                negative damping, or F_s below F_c.
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
        """The model of P. Dahl (1968): one level, no damping.

        Args:
            coulomb: N·m.
            stiffness: of the bristles, N·m/rad.
        """
        return cls(ViscousCoulomb(viscous=0.0, coulomb=coulomb), stiffness, 0.0)

    def check_own(self) -> None:
        """Validate the levels at which the bristles slip.

        Raises:
            InputError: A level is not above zero, or that at rest is below that of fast rotation.
        """
        for direction in (1.0, -1.0):
            peak, low = np.broadcast_arrays(*self._levels(direction))
            require("bristle level", low, "N·m", positive=True)
            below = peak < low * (1.0 - 1e-9)
            if np.any(below):
                raise InputError(
                    f"bristle level at rest: found {peak[below].flat[0]:g} N·m, expected at least "
                    f"that of fast rotation, {low[below].flat[0]:g} N·m"
                )

    def level(self, speed: Scalar) -> Scalar:
        """g(w), N·m: torque at which the bristles slip in steady rotation."""
        direction = jnp.where(jnp.asarray(speed) < 0.0, -1.0, 1.0)
        whole = self.curve.torque(speed, direction)
        return direction * (whole - self.curve.viscous_torque(speed, direction))

    def deflection_rate(self, speed: Scalar, deflection: Scalar) -> Scalar:
        """dz/dt, rad/s."""
        return speed - self.stiffness * jnp.abs(speed) * deflection / self.level(speed)

    def torque(self, speed: Scalar, deflection: Scalar) -> Scalar:
        """F, N·m, on the rotor with its sign turned.

        Args:
            speed: w, rad/s.
            deflection: z, rad.
        """
        direction = jnp.where(jnp.asarray(speed) < 0.0, -1.0, 1.0)
        bristles = self.stiffness * deflection
        damped = self.damping * self.deflection_rate(speed, deflection)
        return bristles + damped + self.curve.viscous_torque(speed, direction)

    def steady_deflection(self, speed: Scalar) -> Scalar:
        """Deflection at which the bristles slip at a steady speed, rad."""
        return jnp.sign(speed) * self.level(speed) / self.stiffness

    def _fast(self, direction: Scalar) -> Scalar:
        """A speed at which the level has settled, rad/s."""
        scale = self.curve.speed_scale()
        return direction * jnp.where(jnp.isinf(scale), 1.0, 10.0 * scale)

    def _levels(self, direction: Scalar) -> tuple[Scalar, Scalar]:
        """Level at rest and of fast rotation, N·m."""
        return self.curve.breakaway_torque(direction), self.level(self._fast(direction))

    def largest_passive_damping(self) -> Scalar:
        """Largest s_1 for which the friction can never give out energy, N·m·s/rad.

        b g(inf) / (T_s - g(inf)); infinite where the level does not fall. Beyond it the damping of
        strongly bent bristles can exceed what they dissipate. N. Barabanov, R. Ortega, "Necessary
        and sufficient conditions for passivity of the LuGre friction model", IEEE Transactions on
        Automatic Control 45 (2000).
        """
        limits = []
        for direction in (1.0, -1.0):
            fast = self._fast(direction)
            viscous = self.curve.viscous_torque(fast, direction) / fast
            peak, low = self._levels(direction)
            falls = peak - low
            limit = viscous * low / jnp.where(falls > 0.0, falls, 1.0)
            limits.append(jnp.where(falls > 0.0, limit, jnp.inf))
        return jnp.minimum(*limits)

    def is_passive(self) -> Scalar:
        """Whether the damping is within `largest_passive_damping`."""
        return self.damping <= self.largest_passive_damping()


def static_curve(friction: Friction | LuGre) -> Friction:
    """The friction of steady rotation: the curve itself, or that of the bristles."""
    return friction.curve if isinstance(friction, LuGre) else friction
