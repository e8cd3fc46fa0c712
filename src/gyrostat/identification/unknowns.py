"""What the samples of a problem leave unknown: rounding, and the times of steps of the current."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.read.quantisation import repetitions, rounding_step
from gyrostat.identification.uncertainty.current_errors import (
    ROUNDED,
    CurrentError,
    constant_torque,
    current_steps,
    rounded_current,
)
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction


@dataclass(frozen=True)
class Unknowns:
    """What the samples of some records leave unknown.

    Attributes:
        errors: Errors of the current.
        rounding: Variance of the current in each interval, independent of others, (N - 1,), A², for
            each record.
        repeated: Number of samples that share one error of the speed, (N,), for each record.
        speed_sigmas: Smallest noise of the speed of each record, rad/s: that of its rounding.
    """

    errors: tuple[CurrentError, ...]
    rounding: tuple[Vector, ...]
    repeated: tuple[Vector, ...]
    speed_sigmas: tuple[float, ...]

    @classmethod
    def of(cls, problem: Problem, records: Sequence[Record], model: type[Friction]) -> "Unknowns":
        """Find or take the steps to which current and speed were rounded.

        Args:
            problem: The problem, with its records as measured.
            records: The same, cut and pooled.
            model: Friction model.
        """
        measured = problem.records
        step = problem.current_quantum
        if step is None:
            step = rounding_step(np.concatenate([r.current for r in measured]))
        errors, rounding = [], [np.zeros(len(r.time) - 1) for r in records]
        if step:
            stated = problem.current_quantum is not None
            held, rounding = rounded_current(records, step, stated=stated)
            errors += [] if held is None else [held]
        viscous = [d for d in model.dimensions().values() if d == "viscous"]
        # two coefficients: one for each sense of rotation
        if "current_bias" not in problem.asked and len(viscous) < 2:
            errors.append(constant_torque(records))
        steps = current_steps(records, problem.current_hold)
        errors += [] if steps is None else [steps]
        repeated, smallest = [], []
        for record, original in zip(records, measured, strict=True):
            step = problem.speed_quantum
            if step is None:
                step = rounding_step(original.speed[original.valid])
            # means of samples are not multiples of the step
            step = 0.0 if step is None or record.averaged else step
            repeated.append(repetitions(record, step) if step else np.ones(len(record.time)))
            smallest.append(ROUNDED * step)
        return cls(tuple(errors), tuple(rounding), tuple(repeated), tuple(smallest))
