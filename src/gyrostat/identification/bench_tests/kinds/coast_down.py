"""Coast-down from both senses of rotation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.units import RPM
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    BenchTest,
    Measured,
    Motor,
    Outcome,
    Panel,
    PlannedRecord,
    speeds_of,
)
from gyrostat.identification.bench_tests.coasting import coast_friction
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.telemetry import Record

FAR = 2.0
"""Largest factor between the speed that a record reaches and the planned one."""


@dataclass(frozen=True)
class CoastDown(BenchTest):
    """J dw/dt = -b w - c: friction relative to the inertia, without the motor.

    The closed solution is fitted to each sense (`gyrostat.identification.bench.coast`).
    """

    name = "coast-down"
    title = "Coast-down from both senses"
    purpose = "loss torque and coast-down time, viscous and Coulomb friction, relative to inertia"
    place = 10
    quantities = ("coast_down_time", "loss_torque", "coulomb", "viscous")

    start_speed: float | None = option(None, "speed", "Speed at which the current is cut.")
    current: float | None = option(None, "current", "Current of the acceleration.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        planned = []
        for sense, word in ((1.0, "positive"), (-1.0, "negative")):
            program = Program(sheet, self.name, sheet.bench.rate)
            program.drive(
                sense * (self.current or sheet.bench.current_limit),
                sense * (self.start_speed or sheet.value("speed_limit")),
            )
            program.coast()
            remark = "switch the motor bridge off for the coast; leave the wheel until it rests"
            planned.append(PlannedRecord(f"{self.name}-{word}", *program.series(), remark))
        return planned

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        top = self.start_speed or sheet.value("speed_limit")
        values, lines = [], []
        for sense, record in zip((1, -1), records, strict=True):
            coasted = coast_friction(sheet, record)
            reached = float(np.max(sense * record.speed[record.valid]))
            if not top / FAR < reached < FAR * top:
                raise InputError(
                    f"{record.name}: found speeds up to {reached / RPM:.4g} rpm in the "
                    f"{'positive' if sense > 0 else 'negative'} sense, expected about "
                    f"{top / RPM:.4g} rpm: sign or unit of the speed"
                )
            grid = np.linspace(0.0, reached, 60)
            lines.append(np.array([sense * grid / RPM, [coasted.loss(w)[0] for w in grid]]))
            for name, method in (("loss_torque", coasted.loss), ("coast_down_time", coasted.time)):
                for speed in speeds_of(sheet, name, (0.5 * top, top)):
                    # beyond the speed of the coast the curve is an extrapolation
                    if 0.95 * speed <= reached:
                        values.append(Measured(name, *method(speed), sense, {"speed": speed}))
            sigmas = np.hypot(
                np.sqrt(np.diag(coasted.covariance)), coasted.scale * coasted.values
            ).tolist()
            pairs = zip(coasted.values.tolist(), sigmas, strict=True)
            values += [
                Measured(name, *pair, sense)
                for name, pair in zip(("viscous", "coulomb"), pairs, strict=True)
            ]
        panel = Panel("Loss torque", "speed (rpm)", "torque (N·m)", lines=tuple(lines))
        return Outcome(tuple(values), panels=(panel,))
