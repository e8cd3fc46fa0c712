"""Output error of the torque: the current of a drive that is simulated in the same control law.

DIDIM (Gautier, Janot and Vandanjon 2013) takes the regressors of the simulated motion for the
sensitivities of the torque, which holds for stiff loops only. Here they are those of the simulated
loop, by differences.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.estimators import (
    CONVERGED,
    EXACT,
    ITERATIONS,
    Regression,
    simulate_all,
)
from gyrostat.identification.drive.parts import Part
from gyrostat.identification.drive.regression import covariance, regress

STEP = 1e-4
"""Relative step of the differences."""
HALVINGS = 6
"""Halvings of a step that does not reduce the error."""


def _currents(
    equation: Equation, parts: Sequence[Part], values: Mapping[str, float], law: ControlLaw
) -> Vector | None:
    """Simulated current in the windows of all parts, weighted, A."""
    loops = simulate_all(equation, parts, values, law)
    if loops is None:
        return None
    pairs = zip(parts, loops, strict=True)
    means = [p.weight * (p.windows.mean @ current)[p.used] for p, (_, current) in pairs]
    return np.concatenate(means)


def _sensitivities(
    equation: Equation, parts: Sequence[Part], values: Vector, current: Vector, law: ControlLaw
) -> Matrix | None:
    """Derivatives of the simulated current by the estimates, (m, n); None if one has no effect."""
    columns = []
    for k in range(len(values)):
        step = np.zeros_like(values)
        # a bias may be zero
        step[k] = STEP * max(
            abs(values[k]),
            1e-3 * float(np.max(np.abs(current))) * (equation.names[k] == "current_bias"),
        )
        moved = _currents(equation, parts, equation.named(values + step), law)
        # a parameter below zero has no effect on the simulated drive
        if moved is None or not np.any(moved != current):
            return None
        columns.append((moved - current) / step[k])
    return np.column_stack(columns)


def minimise_output_error(
    equation: Equation, parts: Sequence[Part], start: Vector, law: ControlLaw
) -> Regression | None:
    """Minimise the error of the simulated current, by Gauss and Newton with step halving.

    Args:
        equation: Equation of motion.
        parts: Segments.
        start: First estimates, (n,), SI.
        law: Control law.

    Returns:
        The estimates, or None if the loop is unstable at the first ones.
    """
    measured = [p.weight * (p.windows.mean @ p.drive.current)[p.used] for p in parts]
    target = np.concatenate(measured)
    values, current = start, _currents(equation, parts, equation.named(start), law)
    if current is None:
        return None
    converged, count = False, 1
    spread = np.zeros((len(start),) * 2)
    while count < ITERATIONS and not converged:
        slopes = _sensitivities(equation, parts, values, current, law)
        if slopes is None:
            break
        error = target - current
        step = regress(slopes, slopes, error)
        spread = covariance(slopes, slopes, error - slopes @ step, [p.used for p in parts])
        sigma = np.sqrt(np.diag(spread))
        count += 1
        converged = bool(np.all(np.abs(step) < CONVERGED * sigma + EXACT * np.abs(values)))
        for _ in range(HALVINGS):
            trial = _currents(equation, parts, equation.named(values + step), law)
            if trial is not None and np.sum((target - trial) ** 2) <= np.sum(error**2):
                values, current = values + step, trial
                break
            step = 0.5 * step
        else:
            break
    motor = equation.named(values)["motor_constant"]
    ends = np.cumsum([len(p.used) for p in parts])[:-1]
    weights = [p.weight for p in parts]
    errors = np.split(motor * (target - current), ends)
    return Regression(
        values,
        spread,
        tuple(e / w for e, w in zip(errors, weights, strict=True)),
        tuple(motor * m / w for m, w in zip(measured, weights, strict=True)),
        strength=np.inf,
        converged=converged,
        iterations=count,
    )
