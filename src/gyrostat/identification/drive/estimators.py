"""Regression on the inverse dynamics, by least squares or with instruments.

Least squares with parallel filters (IDIM-LS) has regressors of the measured motion. Instruments are
the same regressors of a predicted motion (IDIM-IV; Janot, Vandanjon and Gautier 2014).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.motion import Motion
from gyrostat.identification.drive.parts import Part
from gyrostat.identification.drive.regression import covariance, regress, weakest
from gyrostat.identification.drive.simulation import simulate_loop

ITERATIONS = 20
CONVERGED, EXACT = 1e-2, 1e-5
"""Largest change of an estimate in its last iteration: in standard deviations, and of itself."""


@dataclass(frozen=True, eq=False)
class Regression:
    """Result of an estimator.

    Attributes:
        values: Estimates, (n,), SI.
        covariance: Their covariance, (n, n), SI.
        errors: Motor torque of each part that is not explained, (m,), N·m.
        torques: Motor torque of each part, (m,), N·m.
        strength: F statistic of the weakest combination of instruments.
        converged: Whether the iteration converged.
        iterations: Number of regressions.
    """

    values: Vector
    covariance: Matrix
    errors: tuple[Vector, ...]
    torques: tuple[Vector, ...]
    strength: float
    converged: bool = True
    iterations: int = 1

    @property
    def torque_error(self) -> float:
        """Rms error relative to the rms of the motor torque."""
        return relative_rms(np.concatenate(self.errors), np.concatenate(self.torques))


def relative_rms(error: Vector, whole: Vector) -> float:
    """Rms of an error over that of the whole."""
    return float(np.sqrt(np.mean(error**2) / np.mean(whole**2)))


def estimate(
    equation: Equation, parts: Sequence[Part], predicted: Sequence[Motion] | None
) -> Regression:
    """Estimate by one regression.

    Args:
        equation: Equation of motion.
        parts: Segments.
        predicted: Predicted motion of each of them, for the instruments; None for least squares.
    """
    instruments, regressors, targets, rows = [], [], [], []
    for k, part in enumerate(parts):
        rows.append(part.rows(equation, part.drive.measured))
        columns, target = equation.system(rows[-1])
        model = columns
        if predicted is not None:
            model = equation.system(part.rows(equation, predicted[k]))[0]
        instruments.append(part.weight * model)
        regressors.append(part.weight * columns)
        targets.append(part.weight * target)
    z, x, y = np.vstack(instruments), np.vstack(regressors), np.concatenate(targets)
    solution = regress(z, x, y)
    spread = covariance(z, x, y - x @ solution, [part.used for part in parts])
    values, spread = equation.estimates(solution, spread)
    pairs = [equation.torque_error(each, equation.named(values)) for each in rows]
    errors, torques = zip(*pairs, strict=True)
    return Regression(values, spread, errors, torques, weakest(z, x))


def iterate(
    equation: Equation, parts: Sequence[Part], predicted: Sequence[Motion], law: ControlLaw | None
) -> tuple[Regression, tuple[Motion, ...]]:
    """Estimate with instruments, and simulate the closed loop, until the estimates agree.

    Args:
        equation: Equation of motion.
        parts: Segments.
        predicted: Motion of each predicted from the reference, for the first estimate.
        law: Control law; None to keep the predicted motion.

    Returns:
        The last estimate, and the motion of its instruments.
    """
    last, motions = estimate(equation, parts, predicted), tuple(predicted)
    if law is None:
        return last, motions
    for count in range(2, ITERATIONS + 1):
        loops = simulate_all(equation, parts, equation.named(last.values), law)
        if loops is None:
            break
        motions = tuple(motion for motion, _ in loops)
        new = estimate(equation, parts, motions)
        sigma = np.sqrt(np.diag(new.covariance))
        change = np.abs(new.values - last.values)
        last = replace(new, iterations=count)
        if np.all(change < CONVERGED * sigma + EXACT * np.abs(new.values)):
            return last, motions
    return replace(last, converged=False), motions


def simulate_all(
    equation: Equation, parts: Sequence[Part], values: Mapping[str, float], law: ControlLaw
) -> list[tuple[Motion, Vector]] | None:
    """Motion and current of the closed loop in each part; None if one is not finite."""
    if not values["inertia"] > 0.0 or not values["motor_constant"] > 0.0:
        return None
    loops = [simulate_loop(part.drive, equation.law, values, law) for part in parts]
    finite = [loop for loop in loops if loop is not None]
    return finite if len(finite) == len(loops) else None
