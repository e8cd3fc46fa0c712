"""Coupling of vibration modes with the body that carries them."""

from typing import NamedTuple

import equinox as eqx
from jaxtyping import Array, Float

from gyrostat.core.arrays import PerMode, Scalar, Vector3
from gyrostat.core.jax64 import jnp

MODE_STEP = 0.1
"""Largest phase of the fastest mode in one segment, rad. The error of a Runge-Kutta step is then
below 1e-6 of the frequency and below 1e-7 in the damping ratio."""


class ModalMotion(NamedTuple):
    """Motion of the modes, or its time derivative.

    Attributes:
        coordinate: Modal coordinates q, (modes,), √kg·m.
        momentum: Generalised momenta p = M q' + D w, (modes,), √kg·m/s.
    """

    coordinate: PerMode
    momentum: PerMode


def with_names(modal: ModalMotion | None) -> dict[str, PerMode]:
    """Fields of a `GyrostatState` with the motion of its modes; none for a rigid body."""
    if modal is None:
        return {}
    return {"modal_coordinate": modal.coordinate, "modal_momentum": modal.momentum}


class ModalCoupling(eqx.Module):
    """Linear relations between the motion of modes and that of the body; see `FlexibleModes`.

    With p = M q' + D w as state, the body rate is a function of the state: q' = M^-1 p - B w with
    B = M^-1 D, and H = (J - D^T B) w + A h + B^T p. The body moves as one of the inertia J - D^T B,
    on which the modes act with the torque B^T f, where f = -p' = 2 Z W q' + W² q. All relations are
    linear and constant, so that they also hold for the time derivatives of their arguments.

    Attributes:
        stiffness: W², (modes,), 1/s².
        drag: 2 Z W, (modes,), 1/s.
        inverse_mass: M^-1, (modes, modes); None for M = 1.
        arms: B, (modes, 3), √kg·m.
        inertia: D^T B, the inertia that follows the body only through springs, (3, 3), kg·m².
    """

    stiffness: PerMode
    drag: PerMode
    inverse_mass: Float[Array, "modes modes"] | None
    arms: Float[Array, "modes 3"]
    inertia: Float[Array, "3 3"]

    def body_part(self, force: PerMode) -> Vector3:
        """B^T applied to modal momenta or forces: momentum, N·m·s, or torque, N·m, (3,)."""
        return self.arms.T @ force

    def rate(self, momentum: PerMode, turning: Vector3) -> PerMode:
        """Modal rates q', (modes,), √kg·m/s.

        Args:
            momentum: Generalised momenta p, (modes,), √kg·m/s.
            turning: Body rate, (3,), rad/s.
        """
        free = momentum if self.inverse_mass is None else self.inverse_mass @ momentum
        return free - self.arms @ turning

    def derivative(self, modal: ModalMotion, turning: Vector3) -> ModalMotion:
        """Time derivative of the motion of the modes, (q', p').

        Args:
            modal: Motion of the modes; or its derivative, which gives the second derivative.
            turning: Body rate, (3,), rad/s; or its derivative.
        """
        rate = self.rate(modal.momentum, turning)
        return ModalMotion(rate, -(self.drag * rate + self.stiffness * modal.coordinate))

    def fastest_squared(self, inverse: Float[Array, "3 3"]) -> Scalar:
        """Upper bound of the squared eigenvalues of the modes on the free body, 1/s².

        M_f is the modal mass on the free body. The largest row sum of W M_f^-1 W bounds the squared
        frequencies, that of M_f^-1 with the roots of 2 Z W on both sides the decay rates.

        Args:
            inverse: Inverse of the inertia without that of modes and rotors, (3, 3), 1/(kg·m²).
        """
        mass = jnp.eye(len(self.stiffness)) if self.inverse_mass is None else self.inverse_mass
        free = jnp.abs(mass + self.arms @ inverse @ self.arms.T)
        frequency, drag = jnp.sqrt(self.stiffness), jnp.sqrt(self.drag)
        decay = jnp.max(drag * (free @ drag))
        return jnp.maximum(jnp.max(frequency * (free @ frequency)), decay**2)
