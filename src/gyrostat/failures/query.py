"""Validated inputs of a feasibility query."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.validation import LARGEST
from gyrostat.failures.momentum_envelope import MomentumSet
from gyrostat.spacecraft import Spacecraft

NEGLIGIBLE_RATE = 1e-12
"""Body rate that the total momentum could cause, rad/s, below which the momentum counts as zero."""
UNIT_TOLERANCE = 1e-3
"""Largest deviation of the length of a given quaternion from 1; allows for typed numbers."""


@dataclass(frozen=True)
class Case:
    """Spacecraft, its failed wheels and its total momentum.

    Attributes:
        inertia: Inertia with locked wheels, (3, 3), kg·m².
        momentum: Total momentum, (3,), inertial axes, N·m·s.
        radius: Magnitude of the total momentum, N·m·s; 0 if it is negligible.
        working: Indices of the working wheels.
        failed: Index of each failed wheel -> its momentum, N·m·s.
        torque_limits: Torque limits of the working wheels, (N,), N·m.
        held: Momentum envelope of the wheels with the body at rest.
    """

    inertia: Matrix
    momentum: Vector
    radius: float
    working: tuple[int, ...]
    failed: Mapping[int, float]
    torque_limits: Vector
    held: MomentumSet

    @staticmethod
    def of(spacecraft: Spacecraft, momentum: Any, failed: Mapping[int, float]) -> "Case":
        """Validate the inputs and collect them; see `gyrostat.failures.holdable`.

        Raises:
            InputError: An input is invalid; see there.
        """
        spacecraft.check()
        axes = np.asarray(spacecraft.wheels.axes, dtype=float)
        inertia = np.asarray(spacecraft.inertia, dtype=float)
        if axes.ndim != 2 or inertia.ndim != 2:
            raise InputError("spacecraft: found several, expected one")
        count = axes.shape[1]
        for wheel, value in failed.items():
            if wheel not in range(count):
                raise InputError(f"failed: found wheel {wheel}, expected 0 to {count - 1}")
            if not abs(value) <= LARGEST:
                raise InputError(f"failed wheel {wheel}: found {value}, expected N·m·s")
        limits = np.broadcast_to(np.asarray(spacecraft.wheels.momentum_limit, float), count)
        torques = np.broadcast_to(np.asarray(spacecraft.wheels.torque_limit, float), count)
        working = [k for k in range(count) if k not in failed]
        frozen = sum((axes[:, k] * value for k, value in failed.items()), np.zeros(3))
        case = Case(
            inertia=inertia,
            momentum=np.zeros(3),
            radius=0.0,
            working=tuple(working),
            failed=dict(failed),
            torque_limits=torques[working],
            held=MomentumSet.of(axes[:, working], limits[working], frozen),
        )
        return case.at(momentum)

    def at(self, momentum: Any) -> "Case":
        """The same wheels with another total momentum, inertial axes, (3,), N·m·s.

        Raises:
            InputError: The momentum is invalid.
        """
        total = vector(momentum, 3, "momentum", "N·m·s")
        radius = float(np.linalg.norm(total))
        if radius < NEGLIGIBLE_RATE * np.linalg.eigvalsh(self.inertia)[0]:
            radius = 0.0
        return replace(self, momentum=total, radius=radius)

    def all_wheels(self, working: Vector) -> Vector:
        """Momenta of all wheels, N·m·s, from those of the working wheels."""
        every = np.zeros(len(self.working) + len(self.failed))
        every[list(self.working)] = working
        every[list(self.failed)] = list(self.failed.values())
        return every


def vector(value: Any, length: int, name: str, unit: str) -> Vector:
    """Convert to an array of `length` finite numbers, each at most `LARGEST` in magnitude.

    Raises:
        InputError: The value is not such an array.
    """
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.zeros(0)
    # comparisons with NaN are false
    if array.shape != (length,) or not np.all(np.abs(array) <= LARGEST):
        expected = f"{length} finite numbers below {LARGEST:g} {unit}".rstrip()
        raise InputError(f"{name}: found {value}, expected {expected}")
    return array


def unit_vector(value: Any, name: str) -> Vector:
    """Convert to an array of three finite numbers, scaled to unit length.

    Raises:
        InputError: The value is not such an array, or it is zero.
    """
    array = vector(value, 3, name, "")
    size = float(np.linalg.norm(array))
    if size == 0.0:
        raise InputError(f"{name}: found zero, expected a direction")
    return array / size


def unit_quaternion(value: Any, name: str) -> Vector:
    """Convert to a quaternion (4,), scaled to unit length.

    Raises:
        InputError: The value is not a quaternion of unit length within `UNIT_TOLERANCE`.
    """
    quaternion = vector(value, 4, name, "")
    length = float(np.linalg.norm(quaternion))
    if abs(length - 1.0) > UNIT_TOLERANCE:
        raise InputError(f"{name}: found a quaternion of length {length:g}, expected 1")
    return quaternion / length
