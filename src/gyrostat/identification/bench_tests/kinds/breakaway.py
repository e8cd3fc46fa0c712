"""Breakaway by ramps and by a staircase of current, at several angles of the rotor."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

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
from gyrostat.identification.bench_tests.change_point import breakaway
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.bench_tests.repetitions import Estimate, mean_of, scatter_of
from gyrostat.telemetry import Record

FEWEST = 4
"""Smallest number of angles in a sense, for the scatter over angles."""
GOLDEN = 0.618034
"""Fraction of a turn by which the planned angles differ: they fill the circle evenly."""
REST = 2.0
"""Rest without current before each rise, s."""


@dataclass(frozen=True)
class BreakawayTest(BenchTest):
    """The current rises from rest until the wheel moves; then the rotor is turned to a new angle.

    The breakaway torque at one angle is the motor constant times the current at the change point
    (`change_point`). The mean over n angles has the sigma of their scatter over sqrt(n).
    """

    name = "breakaway"
    title = "Breakaway at several angles"
    purpose = "breakaway torque as mean over angles, its scatter over angles"
    place = 20
    quantities = ("static", "torque_ripple", "zero_crossing_torque")

    angles: int = option(12, "count", "Number of angles in each sense.")
    lowest: float = option(0.6, "1", "First current over the expected breakaway current.")
    highest: float = option(1.4, "1", "Last current over the expected breakaway current.")
    rise_time: float = option(20.0, "time", "Duration of a ramp or staircase.")
    levels: int = option(20, "count", "Steps of a staircase.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        if self.angles < FEWEST or not 0.0 < self.lowest < 1.0 < self.highest:
            raise InputError(
                f"{sheet.path}: test.{self.name}: found {self.angles} angles from {self.lowest:g} "
                f"to {self.highest:g}, expected at least {FEWEST}, below 1 and above 1"
            )
        return [self._record(sheet, stairs) for stairs in (False, True)]

    def _record(self, sheet: BenchSheet, stairs: bool) -> PlannedRecord:
        """Rises of alternating sense, each followed by a pulse that turns the rotor on."""
        usual = sheet.breakaway_current()
        program = Program(sheet, self.name, sheet.bench.rate)
        pulse = min(2.5 * usual, sheet.bench.current_limit)
        for k in range(2 * self.angles):
            sense = (-1.0) ** k
            program.hold(0.0, REST)
            if stairs:
                shares = np.linspace(self.lowest, self.highest, self.levels)
                for share in shares:
                    program.hold(sense * share * usual, self.rise_time / self.levels)
            else:
                low, high = (sense * share * usual for share in (self.lowest, self.highest))
                program.ramp(low, high, self.rise_time)
            program.speed = sense * self._speed_after(sheet, usual)
            program.coast()
            # a pulse that turns the rotor by 2 to 3 turns, half of the angle while it coasts
            turns = 2.0 + GOLDEN * k % 1.0
            drive = sheet.value("motor_constant") * pulse - sheet.value("coulomb")
            fall = drive / sheet.value("coulomb")
            angle = 2.0 * np.pi * turns / (1.0 + fall)
            duration = np.sqrt(2.0 * angle * sheet.value("inertia") / drive)
            program.hold(sense * pulse, duration)
            program.speed = sense * drive / sheet.value("inertia") * duration
            program.coast()
        word = "staircase" if stairs else "ramp"
        return PlannedRecord(f"{self.name}-{word}", *program.series())

    def _speed_after(self, sheet: BenchSheet, usual: float) -> float:
        """Speed of the expected wheel at the end of a rise, rad/s."""
        duration = self.rise_time * (self.highest - 1.0) / (self.highest - self.lowest)
        excess = 0.5 * (self.highest - 1.0) * usual * sheet.value("motor_constant")
        excess += sheet.value("static") - sheet.value("coulomb")
        return excess * duration / sheet.value("inertia")

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        values, notes, points, means = [], [], [], {}
        rises = [
            (word, sense, current, sigma)
            for word, record in zip(("ramp", "staircase"), records, strict=True)
            for sense, current, sigma in self.breakaways(sheet, record, word == "staircase")
        ]
        common = motor.relative
        for sense in (1, -1):
            currents = np.array([c for w, s, c, _ in rises if s == sense and w == "ramp"])
            sigmas = np.array([e for w, s, _, e in rises if s == sense and w == "ramp"])
            stair = np.array([c for w, s, c, _ in rises if s == sense and w == "staircase"])
            if len(currents) < FEWEST or len(stair) < FEWEST:
                raise InputError(
                    f"{records[0].name}: found {len(currents)} breakaways of ramps and "
                    f"{len(stair)} of staircases in one sense, expected at least {FEWEST} each"
                )
            every = np.concatenate([currents, stair])
            means[sense] = mean_of(every).times(motor.constant)
            static = means[sense].widened(common * means[sense].value)
            values.append(Measured.of("static", static, sense))
            noise = float(np.sqrt(np.mean(sigmas**2)))
            ripple = scatter_of(currents, noise).times(motor.constant)
            values.append(Measured.of("torque_ripple", ripple, sense))
            apart = motor.constant * float(currents.mean() - stair.mean())
            notes.append(
                f"{'positive' if sense > 0 else 'negative'} sense: {len(currents)} ramps, "
                f"{len(stair)} staircases; ramps minus staircases {1e6 * apart:+.3g} µN·m"
            )
            points.append((sense, motor.constant * currents, motor.constant * sigmas))
        total, *sigmas = np.array([*zip(*means.values(), strict=True)])
        total = Estimate(float(total.sum()), *(float(np.linalg.norm(each)) for each in sigmas))
        total = total.widened(common * total.value)
        values.append(Measured.of("zero_crossing_torque", total))
        rows = [
            np.array([sense * np.arange(1, len(torque) + 1), torque, error])
            for sense, torque, error in points
        ]
        panel = Panel(
            "Breakaway torque of each ramp",
            "ramp, negative sense to the left",
            "torque (N·m)",
            points=np.concatenate(rows, axis=1),
        )
        notes.append(f"currents to torques by {motor.source}")
        return Outcome(tuple(values), notes=tuple(notes), panels=(panel,))

    def breakaways(
        self, sheet: BenchSheet, record: Record, stairs: bool
    ) -> list[tuple[int, float, float]]:
        """Sense, breakaway current, A, and its sigma of each rise of a record."""
        found = []
        for part in rises(record.current):
            time = record.time[part]
            sense = int(np.sign(record.current[part][-1]))
            current = sense * record.current[part]
            valid = record.valid[part]
            quantum = sheet.bench.speed_quantum
            noise = max(sheet.bench.speed_sigma, quantum / np.sqrt(12.0))
            start = breakaway(time[valid], sense * record.speed[part][valid], noise)
            if start is None:
                continue
            index = int(np.searchsorted(time, start.time, side="right")) - 1
            slope = (current[-1] - current[0]) / (time[-1] - time[0])
            rounding = sheet.bench.current_quantum / np.sqrt(12.0)
            if stairs:
                # the wheel held at the level before, and moves at this one
                below = current[current < current[index] - 0.25 * (np.ptp(current) / self.levels)]
                step = current[index] - (below.max() if len(below) else current[0])
                value, error = current[index] - 0.5 * step, step / np.sqrt(12.0)
            else:
                line = np.polyfit(time, current, 1)
                value, error = float(np.polyval(line, start.time)), 0.0
            sigma = float(np.sqrt((slope * start.sigma) ** 2 + rounding**2 + error**2))
            found.append((sense, float(value), sigma))
        return found


def rises(current: Vector) -> list[slice]:
    """Parts of a record in which the size of the current rises to its largest, with a sign.

    A pulse that does not rise slowly is none.
    """
    sign = np.sign(np.where(np.abs(current) > 0.1 * np.max(np.abs(current)), current, 0.0))
    edges = np.flatnonzero(np.diff(np.concatenate([[0.0], sign, [0.0]]))).tolist()
    parts = []
    for first, last in pairwise(edges):
        part = np.abs(current[first:last])
        if sign[first] == 0.0 or len(part) < 10:
            continue
        grows = part[-1] > 1.2 * part[0] and np.mean(np.diff(part) < 0.0) < 0.4
        if grows:
            parts.append(slice(first, last))
    return parts
