"""Repeated zero crossings."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.bench_tests.bench_sheet import VISCOUS_ERROR, BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    BenchTest,
    Measured,
    Motor,
    Outcome,
    Panel,
    PlannedRecord,
)
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.bench_tests.repetitions import mean_of, scatter_of
from gyrostat.telemetry import Record

FEWEST = 4
"""Smallest number of crossings."""
NEAR, FAR = 0.1, 0.9
"""Part of the largest speed in which the slopes before and after a crossing are fitted: near zero
the friction rises to its static level."""
LEAST = 8
"""Smallest number of samples of each slope."""


@dataclass(frozen=True)
class ZeroCrossing(BenchTest):
    """The wheel passes zero speed at constant current, again and again.

    The torque does not change, so that the acceleration steps by (F(0+) + F(0-)) / J. Half of the
    step is the Coulomb torque, mean of both senses; its scatter about a line over the record is the
    repeatability. The slopes
    are those at the mean speeds before and after: the viscous torque there, by the coefficient of
    the sheet, is subtracted.
    """

    name = "zero-crossing"
    title = "Repeated zero crossings"
    purpose = "Coulomb torque from the step of acceleration, and its scatter"
    place = 30
    quantities = ("crossing_repeatability", "coulomb")

    crossings: int = option(20, "count", "Number of crossings.")
    speed: float = option(100.0 * RPM, "speed", "Speed before and after each crossing.")
    current: float = option(1.6, "1", "Current over the breakaway current.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        if self.crossings < FEWEST or self.current <= 1.0:
            raise InputError(
                f"{sheet.path}: test.{self.name}: found {self.crossings} crossings at "
                f"{self.current:g} breakaway currents, expected at least {FEWEST} above 1"
            )
        current = self.current * sheet.breakaway_current()
        program = Program(sheet, self.name, sheet.bench.rate)
        program.drive(current, self.speed)
        for k in range(self.crossings):
            sense = -((-1.0) ** k)
            program.drive(sense * current, sense * self.speed)
        program.coast()
        return [PlannedRecord(self.name, *program.series())]

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        (record,) = records
        inertia = sheet.value("inertia")
        viscous = sheet.value("viscous")
        crossings = acceleration_steps(record)
        steps = [
            (inertia * step - viscous * apart, inertia * error) for step, error, apart in crossings
        ]
        if len(steps) < FEWEST:
            raise InputError(
                f"{record.name}: found {len(steps)} zero crossings at constant current, expected "
                f"at least {FEWEST}"
            )
        torque, sigma = np.array(steps).T
        numbers = 1.0 + np.arange(float(len(torque)))
        line = np.polyfit(numbers, torque, 1)
        trend = np.polyval(line, numbers)
        # friction that drifts over the record is no scatter from crossing to crossing
        level = torque - trend + torque.mean()
        error = VISCOUS_ERROR * viscous * float(np.mean([each[2] for each in crossings]))
        step = mean_of(level)
        step = step.widened(sheet.inertial_scale() * step.value).widened(error)
        scatter = scatter_of(level, float(np.sqrt(np.mean(sigma**2))), fitted=2)
        panel = Panel(
            "Step of the torque at each crossing",
            "crossing",
            "torque (N·m)",
            points=np.array([numbers, torque, sigma]),
            lines=(np.array([numbers, trend]),),
        )
        note = (
            f"{len(torque)} crossings evaluated; the step changes by "
            f"{1e6 * (trend[-1] - trend[0]):+.3g} µN·m over the record, which is no part of the "
            "scatter"
        )
        values = (
            Measured.of("coulomb", step.times(0.5)),
            Measured.of("crossing_repeatability", scatter),
        )
        return Outcome(values, (), (note,), (panel,))


def acceleration_steps(record: Record) -> list[tuple[float, float, float]]:
    """Steps of the acceleration at zero crossings with constant current.

    Returns:
        For each crossing the step, rad/s², its sigma, rad/s², and the difference of the mean speeds
        after and before, rad/s.
    """
    change = np.abs(np.diff(record.current))
    edges = np.flatnonzero(change > 0.2 * np.max(np.abs(record.current))) + 1
    borders = [0, *edges.tolist(), len(record.time)]
    steps = []
    for first, last in pairwise(borders):
        index = np.arange(first, last)[record.valid[first:last]]
        if len(index) < 3 * LEAST or abs(np.mean(record.current[first:last])) == 0.0:
            continue
        sense = np.sign(np.mean(record.current[first:last]))
        speed, time = sense * record.speed[index], record.time[index]
        top = min(-speed.min(), speed.max())
        before = np.flatnonzero((speed < -NEAR * top) & (speed > -FAR * top))
        after = np.flatnonzero((speed > NEAR * top) & (speed < FAR * top))
        if top <= 0.0 or min(len(before), len(after)) < LEAST or before[0] > after[0]:
            continue
        sides = [_slope(time[side], speed[side]) for side in (before, after)]
        step, sigma = sides[0][0] - sides[1][0], float(np.hypot(sides[0][1], sides[1][1]))
        steps.append((step, sigma, float(speed[after].mean() - speed[before].mean())))
    return steps


def _slope(time: Vector, speed: Vector) -> tuple[float, float]:
    """Slope of a line through speeds, and its sigma, rad/s²."""
    rows: NDArray[np.float64] = np.column_stack([np.ones(len(time)), time - time.mean()])
    solution, *_ = np.linalg.lstsq(rows, speed, rcond=None)
    residual = speed - rows @ solution
    variance = float(residual @ residual) / max(len(time) - 2, 1)
    return float(solution[1]), float(np.sqrt(variance / (rows[:, 1] @ rows[:, 1])))
