"""Motion of the line of sight in the windows of simulated runs, from their wheel speeds."""

from dataclasses import replace
from typing import Any, NamedTuple, Self

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.microvibration.disturbance_file import Structure
from gyrostat.microvibration.mounting import senses_of
from gyrostat.microvibration.sight import LineOfSight, line_of_sight
from gyrostat.runs.reference_path import nominal_setup
from gyrostat.scenario.scenario import Scenario

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
        wheels = structure.wheels
        senses = senses_of(wheels, scenario.wheels, np.array(scenario.axes), scenario.name)
        speed = np.linspace(*structure.speeds, count)
        motion = line_of_sight(
            wheels, structure.transfer, speed, structure.exposure, structure.limit
        )
        return cls(replace(motion, most=MARGIN * greatest_speed(scenario)), senses)

    def rms(self, speed: Matrix, inside: Any) -> float:
        """Root mean square of smear and jitter in exposures at some samples, rad.

        NaN: no sample, or a wheel is faster than the speeds of the structure.

        Args:
            speed: Wheel speeds of a run, (samples, wheels), rad/s.
            inside: Whether each sample counts, (samples,).
        """
        speed = np.asarray(speed)[np.asarray(inside)] * self.senses
        return float(np.sqrt(np.mean(self.sight.in_run(speed)))) if len(speed) else np.nan


def greatest_speed(scenario: Scenario) -> float:
    """Greatest nominal speed of any wheel by its momentum limit, rad/s."""
    wheels = nominal_setup(scenario).plant.spacecraft.wheels
    return float(np.max(np.asarray(wheels.momentum_limit) / np.asarray(wheels.inertia)))
