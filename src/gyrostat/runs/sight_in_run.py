"""Motion of the line of sight in the windows of simulated runs, from their wheel speeds."""

from dataclasses import replace
from typing import Any, NamedTuple, Self

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.disturbance_file import Structure
from gyrostat.microvibration.sight import LineOfSight, line_of_sight
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.scenario.scenario import Scenario

PARALLEL = 0.999
"""Least cosine between the axes of a wheel of the scenario and of the structure."""
MARGIN = 1.1
"""Factor on the greatest nominal speed of a wheel: dispersed wheels may be faster."""


class SightInRun(NamedTuple):
    """Motion of the line of sight by the wheels of a scenario.

    Attributes:
        sight: Motion over wheel speed.
        senses: 1 for a wheel whose axis is that of the structure, -1 for the opposite, (wheels,).
    """

    sight: LineOfSight
    senses: Vector

    @classmethod
    def of(cls, scenario: Scenario, structure: Structure, count: int) -> Self:
        """Motion of the line of sight by the wheels of a scenario.

        Args:
            scenario: Scenario.
            structure: Wheels on a structure, in the order of the wheels of the scenario.
            count: Number of wheel speeds.

        Raises:
            InputError: The structure has other wheels than the scenario.
        """
        if len(structure.wheels) != len(scenario.wheels):
            raise InputError(
                f"key wheel: found {len(structure.wheels)} wheels on the structure, expected the "
                f"{len(scenario.wheels)} of {scenario.name}"
            )
        axes = np.array(scenario.axes)
        cosines = np.sum([wheel.axis for wheel in structure.wheels] * axes, axis=1)
        for name, cosine, axis, wheel in zip(
            scenario.wheels, cosines, axes, structure.wheels, strict=True
        ):
            if abs(cosine) < PARALLEL:
                raise InputError(
                    f"{wheel.name}: found the axis {np.round(wheel.axis, 4).tolist()}, expected "
                    f"that of wheel {name} of {scenario.name}, {np.round(axis, 4).tolist()}"
                )
        speed = np.linspace(*structure.speeds, count)
        motion = line_of_sight(
            structure.wheels, structure.transfer, speed, structure.exposure, structure.limit
        )
        return cls(replace(motion, most=_greatest_speed(scenario)), np.sign(cosines))

    def rms(self, speed: Matrix, inside: Any) -> float:
        """Root mean square of smear and jitter in exposures at some samples, rad.

        NaN: no sample, or a wheel is faster than the speeds of the structure.

        Args:
            speed: Wheel speeds of a run, (samples, wheels), rad/s.
            inside: Whether each sample counts, (samples,).
        """
        speed = np.asarray(speed)[np.asarray(inside)] * self.senses
        return float(np.sqrt(np.mean(self.sight.in_run(speed)))) if len(speed) else np.nan


def _greatest_speed(scenario: Scenario) -> float:
    """Greatest speed of any wheel by its momentum limit, with a margin, rad/s."""
    wheels = nominal_setup(scenario).plant.spacecraft.wheels
    return MARGIN * float(np.max(np.asarray(wheels.momentum_limit) / np.asarray(wheels.inertia)))
