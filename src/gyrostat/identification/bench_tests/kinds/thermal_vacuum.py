"""Thermal vacuum cycle: loss torque over temperature."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    COLUMNS,
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
from gyrostat.identification.bench_tests.repetitions import largest_of
from gyrostat.telemetry import Record

STABLE = 3.0
"""Largest change of the temperature in a record, K; a larger one is noted."""


@dataclass(frozen=True)
class ThermalVacuum(BenchTest):
    """One coast in each sense at every plateau of the cycles, cold and hot in turn.

    The largest loss torque of all plateaus is judged, less the amount by which errors alone make
    the largest of several exceed the truth (`largest_of`). The temperature is that of its column,
    or of the comment `# temperature:` of the record.
    """

    name = "thermal-vacuum"
    title = "Thermal vacuum cycle"
    purpose = "loss torque at each temperature plateau, and the largest of them"
    place = 50
    quantities = ("thermal_loss_torque",)

    cycles: int = option(2, "count", "Number of cycles.")
    cold: float = option(-10.0, "temperature", "Cold plateau.")
    hot: float = option(50.0, "temperature", "Hot plateau.")
    soak_time: float = option(7200.0, "time", "Soak before each record.")
    tolerance: float = option(5.0, "1", "Largest distance from the planned temperature, K.")
    speed: float | None = option(None, "speed", "Speed; by default half of the speed limit.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        if not self.cold < self.hot:
            raise InputError(
                f"{sheet.path}: test.{self.name}: found cold {self.cold:g} and hot {self.hot:g} "
                "°C, expected the cold plateau below the hot one"
            )
        speed = self.speed or 0.5 * sheet.value("speed_limit")
        planned = []
        for k in range(2 * self.cycles):
            word, temperature = (("cold", self.cold), ("hot", self.hot))[k % 2]
            program = Program(sheet, self.name, sheet.bench.rate)
            for sense in (1.0, -1.0):
                program.drive(sense * sheet.bench.current_limit, sense * speed)
                program.coast()
            remark = (
                f"in vacuum, after {self.soak_time / 3600.0:.3g} h at {temperature:g} °C: start at "
                "rest"
            )
            name = f"{self.name}-{word}-{k // 2 + 1}"
            columns = (*COLUMNS, "temperature_degC")
            planned.append(PlannedRecord(name, *program.series(), remark, columns, temperature))
        return planned

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        top = self.speed or 0.5 * sheet.value("speed_limit")
        series = [_temperature(record) for record in records]
        temperatures = np.array([each.mean() for each in series])
        for k, (record, warm) in enumerate(zip(records, series, strict=True)):
            wanted = (self.cold, self.hot)[k % 2]
            if np.max(np.abs(warm - wanted)) > self.tolerance:
                raise InputError(
                    f"{record.name}: found {np.min(warm):.1f} to {np.max(warm):.1f} °C, expected "
                    f"the plateau of {wanted:g} °C within {self.tolerance:g} K"
                )
        coasts = [coast_friction(sheet, record) for record in records]
        values, panels = [], []
        for speed in speeds_of(sheet, "thermal_loss_torque", (top,)):
            if speed > 1.05 * top:
                continue
            rows = np.array([coasted.loss(speed) for coasted in coasts])
            # the scale of the instruments is the same at all plateaus
            common = sheet.inertial_scale() * rows[:, 0]
            own = np.sqrt(np.maximum(rows[:, 1] ** 2 - common**2, 0.0))
            largest = largest_of(rows[:, 0], own, [k % 2 for k in range(len(rows))])
            largest = largest.widened(sheet.inertial_scale() * largest.value)
            values.append(Measured.of("thermal_loss_torque", largest, 0, {"speed": speed}))
            panels.append(
                Panel(
                    f"Loss torque at {speed:.4g} rad/s",
                    "temperature (°C)",
                    "torque (N·m)",
                    points=np.array([temperatures, *rows.T]),
                )
            )
        changes = [float(np.ptp(each)) for each in series]
        notes = [
            f"{record.name}: temperature {t:.1f} °C"
            + (f", which changes by {change:.1f} K during the record" if change > STABLE else "")
            for record, t, change in zip(records, temperatures, changes, strict=True)
        ]
        return Outcome(tuple(values), notes=tuple(notes), panels=tuple(panels))


def _temperature(record: Record) -> Vector:
    """Temperature of a record, (N,), °C."""
    if record.temperature is None:
        raise InputError(
            f"{record.name}: found no temperature, expected a column temperature_degC or a comment "
            "# temperature: 21 degC"
        )
    return record.temperature
