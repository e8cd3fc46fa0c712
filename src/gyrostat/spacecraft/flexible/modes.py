"""Vibration modes of flexible appendages and propellant, in hybrid coordinates."""

from typing import Annotated, Any, Self

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.core.arrays import PerMode, Scalar, Vector3
from gyrostat.core.checked import Checked, finite, positive, size
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.linear import inverse_definite
from gyrostat.spacecraft.flexible.coupling import ModalCoupling, ModalMotion
from gyrostat.wheel.array import listed


class FlexibleModes(Checked):
    """Modes of appendages that are fixed to a body at rest (cantilever modes), of unit modal mass.

    q (modes,) are the modal coordinates, w is the body rate, and no external force acts:

        M q'' + 2 Z W q' + W² q = -D w',  M = 1 - S S^T,
        H = J w + A h + D^T q'.

    W are the frequencies, Z the damping ratios, D the rotational and S the translational
    participation. H is the angular momentum in body axes and J the inertia of the undeformed
    spacecraft. The term S S^T is the motion of the body that keeps the centre of mass at rest.
    P. W. Likins, "Dynamics and control of flexible space vehicles", JPL TR 32-1329 (1970). The
    model is of first order in the deflection: it neglects the change of inertia with q and the
    effect of the body rate on the stiffness.

    Attributes:
        frequency: Frequency of each mode on a body at rest, (modes,), rad/s.
        damping: Damping ratio of each mode on a body at rest, (modes,).
        participation: Rotational participation D, the angular momentum about the centre of mass per
            modal rate, body axes, (modes, 3), √kg·m.
        translation: Translational participation over the root of the mass of the spacecraft, S,
            body axes, (modes, 3), dimensionless; None for modes whose deflection does not move the
            centre of mass.
    """

    frequency: Annotated[PerMode, positive("mode frequency", "rad/s")] = eqx.field(converter=listed)
    damping: Annotated[PerMode, size("mode damping")] = eqx.field(converter=listed)
    participation: Annotated[
        Float[Array, "modes 3"], finite("participation of a mode", "√kg·m")
    ] = eqx.field(converter=listed)
    translation: Annotated[Float[Array, "modes 3"] | None, finite("translation of a mode", "1")] = (
        eqx.field(converter=listed, default=None)
    )

    @property
    def count(self) -> int:
        """Number of modes."""
        return np.shape(self.participation)[-2]

    def check_own(self) -> None:
        """Validate shapes and the modal mass.

        Raises:
            InputError: A shape differs from those of the attributes, or the modes carry more mass
                than the spacecraft has.
        """
        per_mode, vectors = np.shape(self.frequency), (*np.shape(self.frequency), 3)
        sizes = {"damping": per_mode, "participation": vectors, "translation": vectors}
        for name, shape in sizes.items():
            value = getattr(self, name)
            if value is not None and np.shape(value) != shape:
                raise InputError(f"mode {name}: found shape {np.shape(value)}, expected {shape}")
        if self.translation is not None:
            translation = np.asarray(self.translation)
            mass_share = np.max(np.linalg.svd(translation, compute_uv=False)) ** 2
            if not mass_share < 1.0:
                raise InputError(
                    f"mode translation: found modes that carry {mass_share:g} of the mass of the "
                    "spacecraft, expected less than 1"
                )

    @classmethod
    def joined(cls, *parts: Self) -> Self:
        """Modes of several appendages.

        Args:
            parts: Modes of each; those without translation do not move the centre of mass.
        """
        rows = [
            jnp.zeros(np.shape(part.participation))
            if part.translation is None
            else part.translation
            for part in parts
        ]
        is_fixed = all(part.translation is None for part in parts)
        frequency, damping, participation = (
            jnp.concatenate([jnp.asarray(getattr(part, name)) for part in parts])
            for name in ("frequency", "damping", "participation")
        )
        return cls(frequency, damping, participation, None if is_fixed else jnp.concatenate(rows))

    def check_inertia(self, inertia: ArrayLike) -> None:
        """Validate that the body without the inertia of the modes has some left.

        Args:
            inertia: Inertia of the undeformed spacecraft without that of the rotors about their
                axes, (..., 3, 3), kg·m².

        Raises:
            InputError: J - D^T M^-1 D is not positive definite.
        """
        arms = participation = np.asarray(self.participation, dtype=float)
        if self.translation is not None:
            translation = np.asarray(self.translation, dtype=float)
            arms = np.linalg.solve(np.eye(self.count) - translation @ translation.mT, participation)
        remaining = np.asarray(inertia) - participation.mT @ arms
        lowest = np.min(np.linalg.eigvalsh(remaining))
        if not lowest > 0.0:
            raise InputError(
                f"participation of the modes: found {lowest:g} kg·m² as least inertia of the body "
                "without that of its modes, expected above 0"
            )

    def start(self, coordinate: Any, rate: Any, turning: Vector3) -> tuple[ModalMotion, Vector3]:
        """Motion of the modes, and their momentum in body axes, (3,), N·m·s.

        Args:
            coordinate: Modal coordinates, (modes,), or one value for all, √kg·m; None for 0.
            rate: Modal rates, (modes,), or one value for all, √kg·m/s; None for 0.
            turning: Body rate, (3,), rad/s.
        """
        participation = jnp.asarray(self.participation)
        coordinate, rate = (
            jnp.zeros(self.count) + (0.0 if x is None else jnp.asarray(x, dtype=float))
            for x in (coordinate, rate)
        )
        momentum = rate + participation @ turning
        if self.translation is not None:
            translation = jnp.asarray(self.translation)
            momentum = momentum - translation @ (translation.T @ rate)
        return ModalMotion(coordinate, momentum), participation.T @ rate

    def coupling(self) -> ModalCoupling:
        """Coupling of the modes with the body."""
        participation, frequency = jnp.asarray(self.participation), jnp.asarray(self.frequency)
        inverse, arms = None, participation
        if self.translation is not None:
            translation = jnp.asarray(self.translation)
            inverse = inverse_definite(jnp.eye(self.count) - translation @ translation.T)
            arms = inverse @ participation
        return ModalCoupling(
            stiffness=frequency**2,
            drag=2.0 * jnp.asarray(self.damping) * frequency,
            inverse_mass=inverse,
            arms=arms,
            inertia=participation.T @ arms,
        )

    def strain_energy(self, coordinate: PerMode) -> Scalar:
        """Elastic energy of the modes, J.

        Args:
            coordinate: Modal coordinates, (modes,), √kg·m.
        """
        return 0.5 * jnp.sum((jnp.asarray(self.frequency) * coordinate) ** 2)
