"""Time shift between current and speed, which biases friction."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.motion import Motion
from gyrostat.identification.drive.parts import Part
from gyrostat.identification.drive.regression import covariance, regress


class Delay(NamedTuple):
    """Time shift that the equation of motion shows, and the estimates with it.

    Attributes:
        time: Delay of the recorded current against the recorded speed, s; negative: of the speed.
        sigma: Its standard deviation, s.
        interval: Shortest sample interval of a segment, s.
        values: Estimates with the shift as a further unknown, (n,), SI.
    """

    time: float
    sigma: float
    interval: float
    values: Vector


def delay(equation: Equation, parts: Sequence[Part], predicted: Sequence[Motion]) -> Delay:
    """Estimate the delay of the current, as a further unknown of the regression.

    A current that was recorded late by T is I - T dI/dt. The derivative is an average over windows,
    as that of the speed; its instrument is the change of the predicted acceleration.

    Args:
        equation: Equation of motion.
        parts: Segments.
        predicted: Predicted motion of each of them, for the instruments.
    """
    scale = equation.held.get("motor_constant", 1.0)
    instruments, regressors, targets = [], [], []
    for part, motion in zip(parts, predicted, strict=True):
        columns, target = equation.system(part.rows(equation, part.drive.measured))
        model = equation.system(part.rows(equation, motion))[0]
        acceleration = np.diff(motion.speed) / np.diff(part.drive.time)
        change, jerk = (
            -scale * (part.windows.slope @ series)[part.used]
            for series in (part.drive.current, acceleration)
        )
        instruments.append(part.weight * np.column_stack([model, jerk]))
        regressors.append(part.weight * np.column_stack([columns, change]))
        targets.append(part.weight * target)
    z, x, y = np.vstack(instruments), np.vstack(regressors), np.concatenate(targets)
    solution = regress(z, x, y)
    spread = covariance(z, x, y - x @ solution, [part.used for part in parts])
    values, _ = equation.estimates(solution[:-1], spread[:-1, :-1])
    interval = min(part.drive.interval for part in parts)
    return Delay(float(solution[-1]), float(np.sqrt(spread[-1, -1])), interval, values)
