"""Friction with bristles that deflect before they slip."""

from collections.abc import Mapping
from typing import Annotated, ClassVar, Self

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.validation import require
from gyrostat.wheel.friction.base import Friction, trial_values

_BRISTLES: Mapping[str, str] = {"stiffness": "stiffness", "damping": "viscous"}


class Bristles(Checked):
    """Friction with a state: dz/dt = w - s_0 abs(w) z / g(w) and F = s_0 z + s_1 dz/dt + b w.

    In this rotary form z is an angle and g a torque: the level of a static friction curve without
    its viscous part. In steady rotation F is that curve. A subclass names the law of its curve; it
    is registered by its file alone.

    Attributes:
        name: Name in model files.
        title: Name in reports.
        held_by_default: Parameters that an identification does not estimate by default.
        curve_law: Law of the curve of a model from named values.
        curve: Static friction curve, which gives g and the viscous part.
        stiffness: Stiffness s_0 of the bristles, N·m/rad.
        damping: Damping s_1 of the bristles, N·m·s/rad.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    held_by_default: ClassVar[tuple[str, ...]] = ("stiffness",)
    curve_law: ClassVar[type[Friction]]

    curve: Friction
    stiffness: Annotated[Scalar, positive("bristle stiffness", "N·m/rad")]
    damping: Annotated[Scalar, size("bristle damping", "N·m·s/rad")]

    @property
    def bristles(self) -> Self:
        """The model itself; None of a static curve."""
        return self

    @classmethod
    def of(cls, **values: Scalar) -> Self:
        """Model from the values of `dimensions`, which are not validated."""
        with trial_values():
            curve = cls.curve_law.of(**{n: values[n] for n in cls.curve_law.dimensions()})
            return cls(curve, **{name: values[name] for name in _BRISTLES})

    @classmethod
    def dimensions(cls) -> dict[str, str]:
        """Name of each parameter of curve and bristles -> dimension; see `Friction.dimensions`."""
        return {**cls.curve_law.dimensions(), **_BRISTLES}

    @classmethod
    def signed(cls) -> tuple[str, ...]:
        """Parameters that may be negative: those of the curve."""
        return cls.curve_law.signed()

    def parameters(self) -> dict[str, Scalar]:
        """Parameter names of curve and bristles in order -> values in SI units."""
        return {**self.curve.parameters(), **{name: getattr(self, name) for name in _BRISTLES}}

    def check_own(self) -> None:
        """Validate the levels at which the bristles slip.

        Raises:
            InputError: A level is not above zero, or the level at rest is below that of fast
                rotation.
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
        """Torque g(w) at which the bristles slip in steady rotation, N·m."""
        direction = jnp.where(jnp.asarray(speed) < 0.0, -1.0, 1.0)
        torque = self.curve.torque(speed, direction)
        return direction * (torque - self.curve.viscous_torque(speed, direction))

    def slip_rate(self, speed: Scalar) -> Scalar:
        """Rate s_0 abs(w) / g(w) at which slip relaxes the deflection, 1/s."""
        return self.stiffness * jnp.abs(speed) / self.level(speed)

    def deflection_rate(self, speed: Scalar, deflection: Scalar) -> Scalar:
        """Rate of deflection dz/dt, rad/s."""
        return speed - self.slip_rate(speed) * deflection

    def torque(self, speed: Scalar, deflection: Scalar) -> Scalar:
        """Friction torque F on the rotor with opposite sign, N·m.

        Args:
            speed: Wheel speed w, rad/s.
            deflection: Deflection z of the bristles, rad.
        """
        bristles = self.stiffness * deflection
        damped = self.damping * self.deflection_rate(speed, deflection)
        return bristles + damped + self.viscous_torque(speed)

    def viscous_torque(self, speed: Scalar) -> Scalar:
        """Part of the torque that does not act through bristles, N·m."""
        direction = jnp.where(jnp.asarray(speed) < 0.0, -1.0, 1.0)
        return self.curve.viscous_torque(speed, direction)

    def steady_deflection(self, speed: Scalar) -> Scalar:
        """Deflection at which the bristles slip at a constant speed, rad."""
        return jnp.sign(speed) * self.level(speed) / self.stiffness

    def _fast(self, direction: Scalar) -> Scalar:
        """Speed above which the level is constant, rad/s."""
        scale = self.curve.speed_scale()
        return direction * jnp.where(jnp.isinf(scale), 1.0, 10.0 * scale)

    def _levels(self, direction: Scalar) -> tuple[Scalar, Scalar]:
        """Levels at rest and in fast rotation, N·m."""
        return self.curve.breakaway_torque(direction), self.level(self._fast(direction))

    def largest_passive_damping(self) -> Scalar:
        """Largest s_1 for which the friction model is passive, N·m·s/rad.

        b g(inf) / (T_s - g(inf)); infinite if the level does not fall with speed. Beyond this
        value, the damping of strongly deflected bristles can give out more energy than they
        dissipate. N. Barabanov, R. Ortega, "Necessary and sufficient conditions for passivity of
        the LuGre friction model", IEEE Transactions on Automatic Control 45 (2000).
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


AnyFriction = Friction | Bristles
"""Friction of a wheel: a static curve, or bristles."""


def static_curve(friction: AnyFriction) -> Friction:
    """Friction curve of steady rotation, of a static model or of a bristle model."""
    return friction.curve if isinstance(friction, Bristles) else friction
