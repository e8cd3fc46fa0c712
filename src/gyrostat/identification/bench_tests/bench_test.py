"""Test that a bench runs, as the files of `gyrostat.identification.bench_tests.kinds` define it."""

import abc
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from gyrostat.core.classes_of import classes_of
from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.core.units import RPM, SI_UNIT, Unit
from gyrostat.identification.bench_tests import kinds
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.options import read_options
from gyrostat.identification.bench_tests.repetitions import Estimate
from gyrostat.identification.judge.acceptance_lines import Line, judged
from gyrostat.telemetry import Record
from gyrostat.wheel.sheet_limits import QUANTITIES, Limit

COLUMNS = ("time_s", "current_A", "speed_rad/s")
"""Columns of a record that every test needs."""
UNITS = {
    "speed": Unit("rpm", RPM),
    "viscous": Unit("µN·m·s/rad", 1e-6),
    "motor_constant": Unit("mN·m/A", 1e-3),
}
"""Units of quantities in tables, where they are not SI."""
SMALL_TORQUE = 1e-4
"""Torque below which it is shown in µN·m, N·m."""
SAME = 1e-6
"""Relative difference of two conditions that are the same."""


@dataclass(frozen=True)
class PlannedRecord(Described):
    """One record of a test.

    Attributes:
        name: Name of its files, without suffix.
        time: Sample times, (N,), s.
        current: Current to run, held from sample to sample, (N,), A.
        remark: What to do beside running the current; empty if nothing.
        columns: Columns of the record that the bench writes.
        temperature: Planned temperature, °C; None for that of the room.
    """

    name: str
    time: Vector
    current: Vector
    remark: str = ""
    columns: tuple[str, ...] = COLUMNS
    temperature: float | None = None

    @property
    def duration(self) -> float:
        """Duration, s."""
        return float(self.time[-1])


@dataclass(frozen=True)
class Measured(Described):
    """Value that a test measured.

    Attributes:
        quantity: Key of `gyrostat.wheel.sheet_limits.QUANTITIES`.
        value: Value, SI.
        sigma: Standard deviation, SI.
        sense: Sense of rotation, +1 or -1; 0 for both.
        conditions: Conditions, SI.
        guard: Standard deviation of a normal error with the same one-sided 95 % bound, by which the
            value is judged, SI: larger than sigma if repetitions are few. None if it is sigma.
    """

    quantity: str
    value: float
    sigma: float
    sense: int = 0
    conditions: Mapping[str, float] = field(default_factory=dict)
    guard: float | None = None

    @classmethod
    def of(
        cls,
        quantity: str,
        estimate: Estimate,
        sense: int = 0,
        conditions: Mapping[str, float] | None = None,
    ) -> "Measured":
        """Value from repetitions."""
        value, sigma, guard = estimate
        return cls(quantity, value, sigma, sense, conditions or {}, guard)

    @property
    def unit(self) -> Unit:
        """Unit of the value in tables."""
        dimension = QUANTITIES[self.quantity].dimension
        if dimension == "torque":
            small = abs(self.value) < SMALL_TORQUE
            return Unit("µN·m", 1e-6) if small else Unit("mN·m", 1e-3)
        return UNITS.get(dimension) or Unit(SI_UNIT[dimension])

    def line(self, limit: Limit | None = None) -> Line:
        """Line of the acceptance test; without a limit, one that only states the value."""
        if limit is None:
            bare = (None, -np.inf, np.inf, self.conditions, self.unit, "")
            limit = Limit(self.quantity, *bare)
        sigma = self.sigma if self.guard is None else self.guard
        return Line(limit, self.sense, self.value, sigma, judged(limit, self.value, sigma))

    def meets(self, limit: Limit) -> bool:
        """Whether a limit is on this value."""
        if limit.quantity != self.quantity or set(limit.conditions) != set(self.conditions):
            return False
        pairs = ((self.conditions[name], value) for name, value in limit.conditions.items())
        return all(abs(a - b) <= SAME * abs(b) for a, b in pairs)


@dataclass(frozen=True)
class Panel:
    """Picture of a test: points with error bars and lines, or a map.

    Attributes:
        title: What it shows.
        x: Label of the abscissa, with the unit.
        y: Label of the ordinate, with the unit.
        points: Abscissa, ordinate and sigma, (3, n) each row; empty for none.
        lines: Curves, (2, n) each.
        image: Map over (rows: y, columns: x) with its extent; None without one.
        extent: Left, right, bottom and top of the map.
    """

    title: str
    x: str
    y: str
    points: Matrix = field(default_factory=lambda: np.zeros((3, 0)))
    lines: tuple[Matrix, ...] = ()
    image: Matrix | None = None
    extent: tuple[float, float, float, float] = (0.0, 1.0, 0.0, 1.0)


@dataclass(frozen=True)
class Outcome(Described):
    """What the records of a test show.

    Attributes:
        values: Measured values.
        lines: Lines that the test itself has judged, in place of those of `values`.
        notes: Remarks for the reader.
        panels: Pictures.
    """

    values: tuple[Measured, ...]
    lines: tuple[Line, ...] = ()
    notes: tuple[str, ...] = ()
    panels: tuple[Panel, ...] = ()

    def of(self, limit: Limit) -> list[Line]:
        """Lines on a limit of the sheet."""
        judged_lines = [line for line in self.lines if line.limit is limit]
        return judged_lines or [each.line(limit) for each in self.values if each.meets(limit)]


@dataclass(frozen=True)
class Motor:
    """Motor constant that converts currents to torques.

    Attributes:
        constant: Motor constant, N·m/A.
        sigma: Its standard deviation, N·m/A; None if it is not known.
        source: Where it is from.
    """

    constant: float
    sigma: float | None
    source: str

    @property
    def relative(self) -> float:
        """Relative standard deviation.

        Raises:
            InputError: It is not known.
        """
        if self.sigma is None:
            raise InputError(
                f"motor_constant: found {self.source} without limits on both sides, expected a "
                "tolerance, or the records of torque-speed: it converts currents to torques"
            )
        return self.sigma / self.constant


@dataclass(frozen=True)
class BenchTest(abc.ABC):
    """Test with its profile, record template and verdict; its fields are keys of [test.NAME]."""

    name: ClassVar[str]
    title: ClassVar[str]
    purpose: ClassVar[str]
    place: ClassVar[int]
    """Order in the plan. The verdict on a quantity is that of the first test that measured it."""
    quantities: ClassVar[tuple[str, ...]]
    """Quantities that the test can measure."""

    @abc.abstractmethod
    def records(self, sheet: BenchSheet) -> list[PlannedRecord]:
        """Design the records for a wheel and bench.

        Raises:
            InputError: The bench cannot run the test.
        """

    @abc.abstractmethod
    def evaluate(self, sheet: BenchSheet, records: Sequence[Record], motor: Motor) -> Outcome:
        """Evaluate the records that a bench made, in the order of `records`.

        Raises:
            InputError: The records do not contain the test.
        """


def bench_tests(sheet: BenchSheet) -> dict[str, BenchTest]:
    """Tests by name, in their order, with the options of a sheet.

    Raises:
        InputError: The sheet has options of an unknown test, or unknown options.
    """
    every = sorted(classes_of(kinds, BenchTest), key=lambda kind: kind.place)
    known = {kind.name: kind for kind in every}
    for name in sheet.options:
        if name not in known:
            raise InputError(
                f"{sheet.path}: key test.{name}: found an unknown test, expected one of "
                f"{', '.join(known)}"
            )
    makers: dict[str, Callable[..., BenchTest]] = dict(known)
    return {
        name: make(
            **read_options(sheet.path, f"test.{name}", sheet.options.get(name, {}), known[name])
        )
        for name, make in makers.items()
    }


def speeds_of(sheet: BenchSheet, quantity: str, usual: Sequence[float]) -> list[float]:
    """Speeds at which a quantity is stated: those of its limits, or usual ones, rad/s."""
    stated = [lim.conditions["speed"] for lim in sheet.wheel.limits if lim.quantity == quantity]
    return stated or list(usual)
