"""Parameters of a rigid body with wheels."""

from dataclasses import replace
from typing import Annotated

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.checked import Checked, Rule, positive, three
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft.torques.surfaces import Surfaces
from gyrostat.wheel import WheelArray
from gyrostat.wheel.array import listed

SYMMETRY = 1e-9
"""Largest asymmetry of an inertia matrix, relative to its largest element."""


def check_inertia(inertia: ArrayLike) -> None:
    """Validate the inertia matrix of a rigid body.

    Args:
        inertia: Inertia matrices, (..., 3, 3), kg·m².

    Raises:
        InputError: The matrix is not 3 by 3, not finite, not symmetric or not positive definite, or
            one principal inertia is larger than the sum of the others.
    """
    every = np.asarray(inertia, dtype=float)
    if every.shape[-2:] != (3, 3):
        raise InputError(f"body inertia: found shape {every.shape}, expected (3, 3)")
    for matrix in every.reshape(-1, 3, 3):
        if not np.all(np.isfinite(matrix)):
            raise InputError("body inertia: found a value that is not finite, expected kg·m²")
        if np.max(np.abs(matrix - matrix.T)) > SYMMETRY * np.max(np.abs(matrix)):
            raise InputError(
                "body inertia: found a matrix that is not symmetric, expected equal products of "
                "inertia on both sides of the diagonal"
            )
        least, middle, most = np.linalg.eigvalsh(matrix)
        if least <= 0.0:
            raise InputError(
                f"body inertia: found the principal inertia {least:g} kg·m², expected above 0"
            )
        if most > (least + middle) * (1.0 + SYMMETRY):
            raise InputError(
                f"body inertia: found principal inertias {least:g}, {middle:g}, {most:g} kg·m², "
                "expected none larger than the sum of the others"
            )


of_a_body = Rule("inertia of a rigid body, kg·m²", check_inertia)


class Spacecraft(Checked):
    """Parameters of a rigid body with reaction wheels.

    Attributes:
        inertia: Inertia of body and wheels about the centre of mass in body axes, without the
            inertia of each rotor about its spin axis, (3, 3), kg·m².
        wheels: Reaction wheels.
        mass: Mass with the wheels, kg; None if it is not given.
        centre_of_mass: Centre of mass in body axes, from their origin, (3,), m; None for the
            origin.
        surfaces: Outer surfaces; None if they are not given.
    """

    inertia: Annotated[Float[Array, "3 3"], of_a_body] = eqx.field(converter=listed)
    wheels: WheelArray
    mass: Annotated[Scalar | None, positive("mass", "kg")] = None
    centre_of_mass: Annotated[Vector3 | None, three("centre of mass", "m")] = eqx.field(
        converter=listed, default=None
    )
    surfaces: Surfaces | None = None

    def check_own(self) -> None:
        """Compare the inertia of the body with that of the rotors in it.

        A rotor of spin inertia I about its axis a has at least I / 2 across it (thin disc), which
        is part of the body's inertia: J - sum I (E - a a') / 2 is positive definite.

        Raises:
            InputError: It is not.
        """
        axes, rotors = np.asarray(self.wheels.axes), np.asarray(self.wheels.inertia)
        inertia = np.asarray(self.inertia, dtype=float)
        across = np.eye(3) - np.einsum("...iw,...jw->...wij", axes, axes)
        rotor = np.sum(0.5 * (rotors * np.ones(axes.shape[-1]))[..., None, None] * across, axis=-3)
        least = np.linalg.eigvalsh(inertia - rotor)[..., 0]
        if np.any(least <= 0.0):
            smallest = np.min(np.linalg.eigvalsh(inertia))
            raise InputError(
                f"body inertia: found the principal inertia {smallest:g} kg·m² with wheels of "
                f"{np.max(rotors):g} kg·m², expected more than that of the wheels inside the body"
            )

    def inertia_locked(self) -> Float[Array, "3 3"]:
        """Inertia with all rotors locked to the body, (3, 3), kg·m²."""
        axes = jnp.asarray(self.wheels.axes)
        return self.inertia + (axes * self.wheels.inertia) @ axes.T

    def facets(self, part: str) -> Surfaces:
        """Surfaces with centres from the centre of mass.

        Args:
            part: Part that needs them, for the message.

        Raises:
            InputError: The spacecraft has no surfaces.
        """
        if self.surfaces is None:
            raise InputError(
                f"{part}: found a spacecraft without surfaces, expected [box], [[panel]] or "
                "[[facet]] in its file, or `surfaces` of Spacecraft"
            )
        if self.centre_of_mass is None:
            return self.surfaces
        centre = jnp.asarray(self.surfaces.centre) - self.centre_of_mass
        return replace(self.surfaces, centre=centre)
