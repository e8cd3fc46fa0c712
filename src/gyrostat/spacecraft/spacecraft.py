"""Parameters of a rigid body with wheels."""

from dataclasses import replace
from typing import Annotated, Any

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float
from numpy.typing import ArrayLike, NDArray

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
    if _are_possible(every):
        return
    for matrix in every.reshape(-1, 3, 3):
        if not np.all(np.isfinite(matrix)):
            raise InputError("body inertia: found a value that is not finite, expected kg·m²")
        if np.max(np.abs(matrix - matrix.T)) > SYMMETRY * np.max(np.abs(matrix)):
            raise InputError(
                "body inertia: found a matrix that is not symmetric, expected equal products of "
                "inertia on both sides of the diagonal"
            )
        smallest, middle, largest = np.linalg.eigvalsh(matrix)
        if smallest <= 0.0:
            raise InputError(
                f"body inertia: found the principal inertia {smallest:g} kg·m², expected above 0"
            )
        if largest > (smallest + middle) * (1.0 + SYMMETRY):
            raise InputError(
                f"body inertia: found principal inertias {smallest:g}, {middle:g}, {largest:g} "
                "kg·m², expected none larger than the sum of the others"
            )


def _are_possible(inertia: NDArray[np.float64]) -> bool:
    """Whether all matrices fulfil `check_inertia`."""
    if not np.all(np.isfinite(inertia)):
        return False
    difference = np.max(np.abs(inertia - np.swapaxes(inertia, -1, -2)), axis=(-1, -2))
    if np.any(difference > SYMMETRY * np.max(np.abs(inertia), axis=(-1, -2))):
        return False
    smallest, middle, largest = np.moveaxis(np.linalg.eigvalsh(inertia), -1, 0)
    fits = largest <= (smallest + middle) * (1.0 + SYMMETRY)
    return bool(np.all((smallest > 0.0) & fits))


def beyond_rotors(inertia: Any, axes: Any, rotors: Any) -> list[list[Any]]:
    """Matrix tr(J) - 2 J - sum of I a a^T, see `check_rotors`, as rows.

    Args:
        inertia: Rows of J, kg·m², whose elements may be arrays, one number for each run.
        axes: Spin axis of each wheel.
        rotors: I of each wheel, kg·m².
    """
    trace = sum(inertia[k][k] for k in range(3))
    return [
        [
            (trace if row == column else 0.0)
            - 2.0 * inertia[row][column]
            - sum(i * (a[row] * a[column]) for a, i in zip(axes, rotors, strict=True))
            for column in range(3)
        ]
        for row in range(3)
    ]


def is_positive_definite(rows: Any) -> Any:
    """Whether a symmetric matrix, (3, 3), is positive definite, by its minors (Sylvester).

    Args:
        rows: Its rows, whose elements may be arrays.
    """
    (a, b, c), (_, d, e), (_, _, f) = rows
    minor = a * d - b * b
    return (a > 0.0) & (minor > 0.0) & (minor * f + 2.0 * b * c * e - a * e * e - d * c * c > 0.0)


def check_rotors(inertia: ArrayLike, axes: ArrayLike, rotors: ArrayLike) -> None:
    """Validate that the inertia of a body with wheels contains that of its rotors.

    The second moments of mass S = tr(J) / 2 - J of the spacecraft without its rotors are positive
    semidefinite. An axisymmetric rotor of spin inertia I has at least I / 2 across its axis. As J
    does not contain I, tr(J) / 2 - J - sum of (I / 2) a a^T must be positive definite, with the
    axes a: a cube with one wheel along each axis has more inertia than a wheel.

    Args:
        inertia: Inertia without that of each rotor about its spin axis, (3, 3), kg·m².
        axes: Spin axes of unit length, one column for each wheel, (3, wheels).
        rotors: Inertia of each rotor about its spin axis, (wheels,), kg·m².

    Raises:
        InputError: The inertia is not above that of the rotors.
    """
    matrix, columns = np.asarray(inertia, dtype=float), np.asarray(axes, dtype=float)
    spin = (columns * np.asarray(rotors, dtype=float)) @ columns.T
    beyond = np.array(beyond_rotors(matrix, columns.T, np.broadcast_to(rotors, len(columns.T))))
    twice = beyond + spin
    values, vectors = np.linalg.eigh(beyond)
    if values[0] <= 0.0:
        along = vectors[:, 0]
        found, least = along @ twice @ along, along @ spin @ along
        raise InputError(
            f"body inertia: found {found:.4g} kg·m² for tr(J) - 2 n·J n along n = "
            f"[{', '.join(f'{x:.3g}' for x in along)}], expected more than the {least:.4g} kg·m² "
            "of the wheels: the body is lighter than its own rotors, or a unit is wrong"
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
        """Compare the inertia with that of the rotors; see `check_rotors`."""
        if np.ndim(self.inertia) == 2:  # a batch is checked run by run
            check_rotors(self.inertia, self.wheels.axes, self.wheels.inertia)

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
