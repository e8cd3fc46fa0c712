"""Transfer from loads at the wheels to the line of sight."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.model import TWO_PI


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Measured or computed frequency responses, linear between their frequencies.

    Attributes:
        frequency: Frequencies, increasing, (F,), Hz.
        values: Angles of the line of sight over loads, (F, wheels, 2, 6), rad/N and rad/(N·m); one
            wheel for loads at one point.

    Raises:
        InputError: A shape or number cannot be used.
    """

    frequency: Vector
    values: Any

    def __post_init__(self):
        shape = np.shape(self.values)
        if len(shape) != 4 or shape[0] != len(self.frequency) or shape[2:] != (2, 6):
            raise InputError(
                f"frequency response: found shape {shape}, expected ({len(self.frequency)}, "
                "wheels, 2, 6)"
            )
        if len(self.frequency) < 2 or np.any(np.diff(self.frequency) <= 0.0):
            raise InputError("frequency response: expected two or more increasing frequencies")
        if not np.all(np.isfinite(self.values)):
            raise InputError("frequency response: found a value that is no number")

    @property
    def wheels(self) -> int:
        """Number of wheels; 1 for loads at one point."""
        return self.values.shape[1]

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency, Hz."""
        return float(self.frequency[0]), float(self.frequency[-1])

    def at(self, frequency: Vector, wheel: int) -> Any:
        """Response at frequencies, (N, 2, 6); 0 outside the limits.

        Args:
            frequency: Frequencies, (N,), Hz.
            wheel: Index of the wheel.
        """
        after = np.clip(np.searchsorted(self.frequency, frequency), 1, len(self.frequency) - 1)
        low, high = self.frequency[after - 1], self.frequency[after]
        share = ((frequency - low) / (high - low))[:, None, None]
        inside = (frequency >= self.frequency[0]) & (frequency <= self.frequency[-1])
        values = self.values[:, wheel]
        result = values[after - 1] + share * (values[after] - values[after - 1])
        return result * inside[:, None, None]

    def grid(self) -> Vector:
        """Frequencies that resolve the response, Hz."""
        return self.frequency


@dataclass(frozen=True, eq=False)
class ModalModel:
    """Modes of a structure, normalised to a modal mass of 1.

    Attributes:
        frequency: Natural frequencies, (M,), Hz; 0 for rigid modes.
        damping: Damping ratios, (M,).
        inputs: Mode shapes at the wheels, (wheels, M, 6): displacements, kg^-1/2, and rotations.
        outputs: Angles of the line of sight, (M, 2), rad for a modal coordinate of 1.

    Raises:
        InputError: A shape or number cannot be used.
    """

    frequency: Vector
    damping: Vector
    inputs: Any
    outputs: Matrix

    def __post_init__(self):
        count = len(self.frequency)
        shapes = np.shape(self.damping), np.shape(self.inputs)[1:], np.shape(self.outputs)
        if shapes != ((count,), (count, 6), (count, 2)):
            raise InputError(f"modal model: found shapes {shapes}, expected those of {count} modes")
        if np.any(self.frequency < 0.0) or np.any(self.damping[self.frequency > 0.0] <= 0.0):
            raise InputError("modal model: expected frequencies of 0 or more and damping above 0")

    @property
    def wheels(self) -> int:
        """Number of wheels; 1 for loads at one point."""
        return self.inputs.shape[0]

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency at which the model holds, Hz."""
        return 0.0, np.inf

    def at(self, frequency: Vector, wheel: int) -> Any:
        """Response at frequencies above 0, (N, 2, 6), rad/N and rad/(N·m).

        Args:
            frequency: Frequencies, (N,), Hz.
            wheel: Index of the wheel.
        """
        w, natural = TWO_PI * frequency[:, None], TWO_PI * self.frequency
        modal = 1.0 / (natural**2 - w**2 + 2j * self.damping * natural * w)
        shape = self.outputs[:, :, None] * self.inputs[wheel][:, None]
        result = modal @ shape.reshape(len(self.frequency), -1).astype(complex)
        return result.reshape(len(frequency), 2, 6)

    def grid(self) -> Vector:
        """Frequencies that resolve the response, Hz."""
        elastic = self.frequency[self.frequency > 0.0]
        damping = self.damping[self.frequency > 0.0]
        around = np.concatenate(
            [-np.geomspace(0.1, 30.0, 15)[::-1], [0.0], np.geomspace(0.1, 30.0, 15)]
        )
        near = (elastic[:, None] * (1.0 + damping[:, None] * around)).ravel()
        top = 3.0 * float(elastic.max()) if len(elastic) else 1000.0
        values = np.concatenate([near[near > 0.0], np.geomspace(1e-2, top, 600)])
        return np.unique(values[values <= top])
