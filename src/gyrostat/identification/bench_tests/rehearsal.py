"""Rehearsal of a test: records of the expected wheel, and what the verdict makes of them."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.units import si_unit
from gyrostat.identification.bench_tests.bench_sheet import VISCOUS_ERROR, BenchSheet
from gyrostat.identification.bench_tests.bench_test import (
    BenchTest,
    Measured,
    Motor,
    PlannedRecord,
)
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import rounded
from gyrostat.wheel.sheet_limits import QUANTITIES, Limit
from gyrostat.wheel.uneven_wheel import ORDERS, Ripple, uneven_speeds

BLOCK = 16
"""Number of tests that are simulated at once, which bounds the memory."""
ROOM_TEMPERATURE = 20.0
"""Temperature of a record without a planned one, °C."""


@dataclass(frozen=True)
class Prediction(Described):
    """What a test determines, over n simulated records.

    Attributes:
        measured: Quantity with conditions, and the mean of its values.
        sigma: Median of the sigma that the verdict states; SI.
        scatter: Standard deviation of the values, SI; None with fewer than two.
        count: Number of values.
    """

    measured: Measured
    sigma: float
    scatter: float | None
    count: int

    @property
    def title(self) -> str:
        """Quantity with its conditions and sense."""
        return self.measured.line().title

    @property
    def unit(self) -> str:
        """SI unit."""
        return si_unit(QUANTITIES[self.measured.quantity].dimension)


@dataclass(frozen=True)
class Rehearsal(Described):
    """Simulated records of one test.

    Attributes:
        predictions: What it determines.
        runs: Number of simulated tests.
        failures: Reasons why some gave no result, one for each.
    """

    predictions: tuple[Prediction, ...]
    runs: int
    failures: tuple[str, ...]


def simulated(
    sheet: BenchSheet, planned: PlannedRecord, count: int, random: np.random.Generator
) -> list[Record]:
    """Records of the expected wheel with ripple, drift, noise and rounding.

    The wheel starts at a random angle. Its friction drifts linearly, by a fraction with the
    standard deviation that the sheet states. The drive sets a current exactly and records it
    rounded.

    Args:
        sheet: Spec sheet.
        planned: Profile.
        count: Number of records.
        random: Random generator.
    """
    bench = sheet.bench
    # one wheel, that starts at another angle each time
    phases = np.array(ORDERS) * random.uniform(0.0, 2.0 * np.pi, (count, 1))
    ripple = Ripple.usual(bench.ripple * sheet.value("coulomb"), phases)
    share = 2.0 * planned.time / planned.time[-1] - 1.0
    growth = 1.0 + bench.drift * random.standard_normal((count, 1)) * share
    speeds = uneven_speeds(sheet.expected(), planned.time, planned.current, growth, ripple)
    torque = None
    if "torque_N·m" in planned.columns:
        torque = _reaction(sheet, planned, speeds)
        torque = torque + bench.torque_sigma * random.standard_normal(torque.shape)
    temperature = ROOM_TEMPERATURE if planned.temperature is None else planned.temperature
    records = []
    for k, speed in enumerate(speeds):
        current = planned.current + bench.current_sigma * random.standard_normal(len(speed))
        speed = speed + bench.speed_sigma * random.standard_normal(len(speed))
        warm = "temperature_degC" in planned.columns
        records.append(
            Record(
                planned.name,
                planned.time,
                rounded(current, bench.current_quantum),
                rounded(speed, bench.speed_quantum),
                np.ones(len(speed), dtype=bool),
                temperature=np.full(len(speed), temperature) if warm else None,
                torque=None if torque is None else torque[k],
            )
        )
    return records


def _reaction(sheet: BenchSheet, planned: PlannedRecord, speeds: np.ndarray) -> np.ndarray:
    """Torque on the bench: that which accelerates the rotor, with the opposite sign."""
    rate = np.diff(speeds, axis=1, append=speeds[:, -1:]) / np.diff(planned.time)[0]
    return -sheet.value("inertia") * rate


def rehearse(
    sheet: BenchSheet,
    test: BenchTest,
    planned: Sequence[PlannedRecord],
    runs: int,
    seed: int,
    say: Callable[[str], None],
) -> Rehearsal:
    """Simulate a test and evaluate the records as those of a bench.

    Args:
        sheet: Spec sheet.
        test: Test.
        planned: Its records.
        runs: Number of simulated tests.
        seed: Seed of ripple, drift and noise.
        say: Function that receives progress.
    """
    random = np.random.default_rng([seed, test.place])
    results: dict[tuple[object, ...], list[Measured]] = {}
    failures = []
    for k, records in enumerate(_tests(sheet, planned, runs, random)):
        believed, motor, scales = _calibration(sheet, random)
        try:
            scaled = [record.scaled(**scales) for record in records]
            outcome = test.evaluate(believed, scaled, motor)
        except InputError as error:
            failures.append(str(error))
            continue
        lines = [
            Measured(x.limit.quantity, x.measured, x.sigma, x.sense, x.limit.conditions)
            for x in outcome.lines
            if x.measured is not None and x.sigma is not None
        ]
        found: dict[tuple[object, ...], Measured] = {}
        for each in (*lines, *outcome.values):
            # a value that is judged too counts once
            found.setdefault((each.quantity, each.sense, *each.conditions.items()), each)
        for key, each in found.items():
            results.setdefault(key, []).append(each)
        if (k + 1) % 10 == 0:
            say(f"  {test.name}: {k + 1} of {runs} simulated")
    return Rehearsal(tuple(_prediction(every) for every in results.values()), runs, tuple(failures))


def _tests(
    sheet: BenchSheet, planned: Sequence[PlannedRecord], runs: int, random: np.random.Generator
) -> Iterator[tuple[Record, ...]]:
    """Records of each simulated test; several are simulated at once."""
    # always as many at once: another number would compile the simulation again
    block = min(runs, BLOCK)
    for first in range(0, runs, block):
        series = [simulated(sheet, each, block, random) for each in planned]
        yield from list(zip(*series, strict=True))[: runs - first]


def _calibration(
    sheet: BenchSheet, random: np.random.Generator
) -> tuple[BenchSheet, Motor, dict[str, float]]:
    """Sheet, motor constant and instruments with errors as large as their uncertainties."""
    errors = {
        name: 1.0 + sigma * random.standard_normal() for name, sigma in sheet.tolerances().items()
    }
    inertia = sheet.value("inertia") * errors.pop("inertia", 1.0)
    viscous = sheet.value("viscous") * (1.0 + VISCOUS_ERROR * random.standard_normal())
    values = {**sheet.wheel.values, "inertia": inertia, "viscous": viscous}
    wheel = replace(sheet.wheel, values=values)
    motor = sheet_motor(sheet)
    constant = motor.constant + (motor.sigma or 0.0) * random.standard_normal()
    return replace(sheet, wheel=wheel), replace(motor, constant=constant), errors


def _prediction(every: Sequence[Measured]) -> Prediction:
    values = np.array([each.value for each in every])
    sigma = float(np.median([each.sigma for each in every]))
    scatter = float(np.std(values, ddof=1)) if len(values) > 1 else None
    first = every[0]
    mean = Measured(first.quantity, float(values.mean()), sigma, first.sense, first.conditions)
    return Prediction(mean, sigma, scatter, len(every))


def sheet_motor(sheet: BenchSheet) -> Motor:
    """Motor constant of the sheet; its tolerance is the half width of a uniform distribution.

    Without limits on both sides its sigma is not known.
    """
    constant = sheet.value("motor_constant")
    limit: Limit = next(each for each in sheet.wheel.limits if each.quantity == "motor_constant")
    width = 0.5 * (limit.maximum - limit.minimum)
    scale = sheet.tolerances().get("current_scale", 0.0) * constant
    sigma = float(np.hypot(width / np.sqrt(3.0), scale)) if np.isfinite(width) else None
    return Motor(constant, sigma, "the motor constant of the sheet")
