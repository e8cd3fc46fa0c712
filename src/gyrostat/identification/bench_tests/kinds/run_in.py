"""Run-in: loss torque over hours of rotation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    BenchTest,
    Measured,
    Motor,
    Outcome,
    Panel,
    PlannedRecord,
)
from gyrostat.identification.bench_tests.coasting import coast_friction, each_coast
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.bench_tests.repetitions import size_of, student
from gyrostat.telemetry import Record

HOUR = 3600.0
FEWEST = 4
"""Smallest number of coasts of which the last half shows a change."""
LOWEST = 0.4
"""Speed at the end of a coast over that at its start."""


@dataclass(frozen=True)
class RunIn(BenchTest):
    """Cycles of rotation at one speed in alternating sense, each with a coast.

    The loss torque of each coast is evaluated at the middle of its speeds. Its slope over the last
    half of the cycles is the change per hour that is left after the run-in.
    """

    name = "run-in"
    title = "Run-in"
    purpose = "loss torque over the hours of run-in, and the change per hour that is left"
    place = 40
    quantities = ("run_in_change",)

    cycles: int = option(12, "count", "Number of cycles.")
    hold_time: float = option(600.0, "time", "Rotation at speed in each cycle.")
    speed: float | None = option(None, "speed", "Speed; by default half of the speed limit.")

    def _speed(self, sheet: BenchSheet) -> float:
        return self.speed or 0.5 * sheet.value("speed_limit")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        if self.cycles < FEWEST:
            raise InputError(
                f"{sheet.path}: test.{self.name}.cycles: found {self.cycles}, expected at least "
                f"{FEWEST}"
            )
        program = Program(sheet, self.name, sheet.bench.rate)
        for k in range(self.cycles):
            sense, speed = (-1.0) ** k, self._speed(sheet)
            program.drive(sense * sheet.bench.current_limit, sense * speed)
            program.steady(self.hold_time)
            program.coast(sense * LOWEST * speed)
            # braking with the motor to the other sense
            program.drive(-sense * sheet.bench.current_limit, 0.0)
        remark = "keep the temperature constant; a speed loop may hold the speed between the coasts"
        return [PlannedRecord(self.name, *program.series(), remark)]

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        (record,) = records
        speed = 0.5 * (1.0 + LOWEST) * self._speed(sheet)
        parts = each_coast(record)
        if len(parts) < FEWEST:
            raise InputError(
                f"{record.name}: found {len(parts)} coasts, expected at least {FEWEST}"
            )
        hours = np.array([time for time, _ in parts]) / HOUR
        losses = [coast_friction(sheet, part, drifts=False).loss(speed) for _, part in parts]
        loss, errors = np.array(losses).T
        common = sheet.inertial_scale() * loss
        noise = np.sqrt(np.maximum(errors**2 - common**2, 0.0))
        last = slice(len(loss) // 2, None)
        # what the temperature of the bench does over the record is no run-in
        drift = sheet.bench.drift * float(loss.mean()) / (0.5 * np.ptp(record.time) / HOUR)
        slope, error, factor = _slope(hours[last], loss[last], noise[last])
        sigma, guard = (float(np.hypot(each, drift)) for each in (error, factor * error))
        change = size_of(slope, sigma, guard)
        line = np.array(
            [hours[last], loss[last].mean() + slope * (hours - hours[last].mean())[last]]
        )
        panel = Panel(
            "Loss torque over the run-in",
            "time (h)",
            "torque (N·m)",
            points=np.array([hours, loss, errors]),
            lines=(line,),
        )
        total = float(loss[-1] / loss[0] - 1.0)
        note = f"loss torque of the last coast {100.0 * total:+.2g} % from the first"
        return Outcome((Measured.of("run_in_change", change),), (), (note,), (panel,))


def _slope(x: Vector, y: Vector, noise: Vector) -> tuple[float, float, float]:
    """Slope of a line, its sigma from scatter or noise, and the factor of the sigma for a bound."""
    centred = x - x.mean()
    power = float(centred @ centred)
    slope = float(centred @ y) / power
    residual = y - y.mean() - slope * centred
    freedom = max(len(x) - 2, 1)
    scatter, known = np.sqrt(float(residual @ residual) / freedom), np.sqrt(np.mean(noise**2))
    sigma = float(max(scatter, known) / np.sqrt(power))
    return slope, sigma, 1.0 if known > scatter else student(freedom)
