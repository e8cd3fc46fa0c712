"""Torque noise: spectrum at one speed, waterfall over a coast-down."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    COLUMNS,
    BenchTest,
    Measured,
    Motor,
    Outcome,
    Panel,
    PlannedRecord,
)
from gyrostat.identification.bench_tests.options import option
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.bench_tests.spectrum import Spectrum, spectrum
from gyrostat.telemetry import Record

UNEVEN = 1e-3
"""Largest deviation of a sample interval from their mean, relative, for a spectrum."""
FEWEST = 8
"""Smallest number of segments."""
FLOOR = 1e-4
"""Smallest density of a waterfall over its largest one."""
SHOWN = 0.3
"""Difference of the measured torque from that of the acceleration, relative, that is noted."""
ALIKE, WRONG = 0.95, 3.0
"""Correlation of the measured with the gained momentum above which the torque has the form of the
acceleration, and factor between them from which its unit is wrong."""


@dataclass(frozen=True)
class TorqueNoise(BenchTest):
    """Reaction torque of a fast record (column `torque`), or inertia times acceleration.

    A speed is differenced: its noise is part of the torque then, which is an upper bound.
    """

    name = "torque-noise"
    title = "Torque noise: spectrum and waterfall"
    purpose = "rms torque noise in a band, its spectrum at one speed, its waterfall over speed"
    place = 60
    quantities = ("torque_noise",)

    speed: float | None = option(None, "speed", "Speed; by default half of the speed limit.")
    hold_time: float = option(60.0, "time", "Duration at this speed.")
    low: float = option(1.0, "frequency", "Lower end of the band.")
    high: float | None = option(None, "frequency", "Upper end; by default 0.4 of the fast rate.")
    segment: float = option(4.0, "time", "Length of a segment of the spectrum.")

    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """See `BenchTest.records`."""
        rate = sheet.bench.fast_rate
        high = self.high or 0.4 * rate
        if not 1.0 / self.segment <= self.low < high < 0.5 * rate:
            raise InputError(
                f"{sheet.path}: test.{self.name}: found a band of {self.low:g} to {high:g} Hz at "
                f"{rate:g} Hz with segments of {self.segment:g} s, expected it above one period "
                "of a segment and below half of fast_rate"
            )
        speed = self.speed or 0.5 * sheet.value("speed_limit")
        columns = (*COLUMNS, "torque_N·m")
        planned = []
        for word in ("spectrum", "waterfall"):
            program = Program(sheet, self.name, rate)
            program.drive(sheet.bench.current_limit, speed)
            if word == "spectrum":
                program.steady(self.hold_time)
            else:
                program.coast()
            remark = "reaction torque about the spin axis in torque_N·m, if the bench measures it"
            planned.append(PlannedRecord(f"{self.name}-{word}", *program.series(), remark, columns))
        return planned

    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """See `BenchTest.evaluate`."""
        high = self.high or 0.4 * sheet.bench.fast_rate
        steady, coast = records
        speed = self.speed or 0.5 * sheet.value("speed_limit")
        near = np.abs(np.abs(steady.speed) - speed) <= 0.1 * speed
        index = np.flatnonzero(near & steady.valid)
        if not len(index):
            raise InputError(
                f"{steady.name}: found no sample near {speed / RPM:.0f} rpm, expected "
                f"{self.hold_time:g} s of them"
            )
        # the speed rises before it is held
        start = int(index[-1]) - round(self.hold_time * _rate(steady)) + 1
        held = slice(max(start, int(index[0])), int(index[-1]) + 1)
        first, notes = self._spectrum(sheet, steady, held)
        slow = np.flatnonzero(coast.current != 0.0)
        begin = int(slow[-1]) + 1 if len(slow) else 0
        second, _ = self._spectrum(sheet, coast, slice(begin, len(coast.time)))
        notes += _on_scale(sheet.value("inertia"), steady, held)
        value, sigma = first.rms(self.low, high)
        scale = sheet.inertial_scale() if steady.torque is None else _torque_scale(sheet)
        value = Measured("torque_noise", value, float(np.hypot(sigma, scale * value)))
        if steady.torque is not None and not _torque_scale(sheet):
            notes.append("no uncertainty of the torque instrument is stated: its scale is exact")
        centres: NDArray[np.intp] = begin + second.centres
        speeds = np.abs(coast.speed[centres]) / RPM
        shown = second.frequency <= high
        floor = FLOOR * float(second.rows[:, shown].max() or 1.0)
        image = 10.0 * np.log10(np.maximum(second.rows[:, shown], floor))
        order = np.argsort(speeds)
        grid = np.linspace(speeds[order[0]], speeds[order[-1]], len(order))
        image = image[order[np.searchsorted(speeds[order], grid).clip(0, len(order) - 1)]]
        density = np.array([first.frequency[1:], np.sqrt(first.density[1:])])
        panels = (
            Panel(
                f"Spectrum at {speed / RPM:.0f} rpm",
                "frequency (Hz)",
                "torque (N·m/√Hz)",
                lines=(density[:, density[0] <= high],),
            ),
            Panel(
                "Waterfall: density in dB over speed",
                "frequency (Hz)",
                "speed (rpm)",
                image=image,
                extent=(0.0, float(second.frequency[shown][-1]), grid[0], grid[-1]),
            ),
        )
        return Outcome((value,), notes=tuple(notes), panels=panels)

    def _spectrum(
        self, sheet: BenchSheet, record: Record, part: slice
    ) -> tuple[Spectrum, list[str]]:
        """Spectrum of the torque in a part of a record."""
        rate = _rate(record)
        torque = record.torque
        notes = []
        if torque is None:
            torque = sheet.value("inertia") * np.gradient(_speeds(record), record.time)
            notes.append(
                "no column of the reaction torque: inertia times acceleration, with the noise of "
                "the tachometer in it; the value is an upper bound"
            )
        length = round(self.segment * rate)
        signal = torque[part]
        if len(signal) < (FEWEST + 1) * length // 2:
            raise InputError(
                f"{record.name}: found {len(signal) / rate:.3g} s for the spectrum, expected at "
                f"least {(FEWEST + 1) * self.segment / 2.0:.3g} s"
            )
        if np.ptp(signal) == 0.0:
            raise InputError(
                f"{record.name}: found a torque of {signal[0]:g} N·m throughout, expected its noise"
            )
        return spectrum(signal, rate, length), notes


def _rate(record: Record) -> float:
    """Samples per second of an evenly sampled record, Hz."""
    intervals = np.diff(record.time)
    mean = float(intervals.mean())
    if np.max(np.abs(intervals - mean)) > UNEVEN * mean + 1e-9:
        raise InputError(f"{record.name}: found uneven sample times, expected even ones: spectrum")
    return 1.0 / mean


def _speeds(record: Record) -> Vector:
    """Speeds, (N,), rad/s; missing ones are interpolated."""
    return np.interp(record.time, record.time[record.valid], record.speed[record.valid])


def _on_scale(inertia: float, record: Record, held: slice) -> list[str]:
    """Remark on a measured torque that does not show the acceleration of the rotor.

    Args:
        inertia: Inertia, kg·m².
        record: Record.
        held: Its part at constant speed, after the acceleration, which shows the sensor's offset.

    Raises:
        InputError: It has the form of the acceleration and another scale.
    """
    part = slice(0, held.start)
    if record.torque is None or part.stop < 2:
        return []
    offset = float(np.mean(record.torque[held]))
    gained = inertia * _speeds(record)[part]
    shown = np.cumsum(record.torque[part] - offset) / _rate(record)
    gained, shown = gained - gained.mean(), shown - shown.mean()
    squares = float(gained @ gained)
    if squares == 0.0:
        return []
    share = abs(float(gained @ shown)) / squares
    if abs(share - 1.0) < SHOWN:
        return []
    alike = share * np.sqrt(squares / max(float(shown @ shown), 1e-300))
    if alike > ALIKE and not 1.0 / WRONG < share < WRONG:
        raise InputError(
            f"{record.name}: found a torque of {share:.2g} times inertia times acceleration while "
            "the wheel accelerates, expected about 1: the unit in the header of its column"
        )
    return [
        f"{record.name}: while the wheel accelerates, the torque shows {share:.2g} times inertia "
        "times acceleration: an instrument without slow torques, or a wrong inertia"
    ]


def _torque_scale(sheet: BenchSheet) -> float:
    """Relative sigma of the instrument of the reaction torque."""
    return max((i.uncertainty for i in sheet.instruments if i.quantity == "torque"), default=0.0)
