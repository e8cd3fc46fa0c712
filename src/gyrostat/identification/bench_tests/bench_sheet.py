"""Spec sheet of a wheel with its bench: data sheet, limits, telemetry, instruments, tests.

The tables of quantities are those of a data sheet (`gyrostat.wheel.data_sheet`). Further tables:

[bench]
current_limit = "0.2 A"
speed_sigma = "1 rpm"

[[instrument]]
quantity = "current"
name = "shunt"
uncertainty = "0.2 %"
calibrated = 2026-01-10
due = 2027-01-10

[test.coast-down]     # options of one test
start_speed = "3000 rpm"
"""

import datetime
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described
from gyrostat.core.toml_file import name_text, read_toml, refuse_unknown
from gyrostat.identification.bench_tests.options import option, read_options, share
from gyrostat.wheel import Wheel, WheelSheet, read_wheel_sheet
from gyrostat.wheel.friction import Stribeck

OTHER_TABLES = ("bench", "instrument", "test")
NEEDED = ("inertia", "motor_constant", "coulomb", "viscous", "speed_limit")
"""Quantities whose expected values a plan needs."""
USUAL_STATIC, USUAL_STRIBECK_SPEED = 1.03, 0.418879
"""Static over Coulomb torque, and Stribeck speed, rad/s, of a sheet without them."""
MEASURED = ("current", "speed", "time", "temperature", "torque")
"""Quantities that an instrument measures."""
VISCOUS_ERROR = 0.1
"""Relative sigma of the viscous coefficient of a sheet, which is not that of each wheel."""
LEAST_RATE, LARGEST_RATE = 1.0, 1e5
"""Bounds of the sample rate, Hz; the programs of the tests have steps of some seconds."""


@dataclass(frozen=True)
class Bench(Described):
    """Drive, telemetry and expected effects, SI. The fields are the keys of [bench]."""

    current_limit: float = option(None, "current", "Largest current of the drive.")
    speed_sigma: float = option(None, "speed", "Noise of the measured speed, 1 sigma.")
    rate: float = option(10.0, "frequency", "Samples per second.")
    fast_rate: float = option(200.0, "frequency", "Samples per second of the noise record.")
    speed_quantum: float = option(0.0, "speed", "Step of the recorded speed.")
    current_sigma: float = option(0.0, "current", "Noise of the measured current, 1 sigma.")
    current_quantum: float = option(0.0, "current", "Step of the recorded current.")
    torque_sigma: float = option(0.0, "torque", "Noise of the reaction torque, 1 sigma.")
    inertia_sigma: float = option(0.0, "share", "Uncertainty of the inertia, 1 sigma.")
    ripple: float = option(0.03, "share", "Torque ripple, rms over the dry friction.")
    drift: float = option(0.02, "share", "Drift of friction from mid-record to its end.")


@dataclass(frozen=True)
class Instrument(Described):
    """Instrument of the bench with its calibration.

    Attributes:
        quantity: What it measures: "current", "speed", "time", "temperature" or "torque".
        name: Name or type.
        serial: Serial number; empty if not stated.
        uncertainty: Standard uncertainty of its scale, relative.
        calibrated: Date of the calibration; None if not stated.
        due: Date until which the calibration holds; None if not stated.
        certificate: Number of the certificate; empty if not stated.
    """

    quantity: str
    name: str
    serial: str = ""
    uncertainty: float = 0.0
    calibrated: datetime.date | None = None
    due: datetime.date | None = None
    certificate: str = ""


@dataclass(frozen=True)
class BenchSheet(Described):
    """Spec sheet of a wheel with the bench that tests it.

    Attributes:
        path: Path of the file.
        wheel: Data sheet with expected values and limits.
        bench: Drive and telemetry.
        instruments: Instruments with their calibration.
        options: Name of a test -> its table.
    """

    path: Path
    wheel: WheelSheet
    bench: Bench
    instruments: tuple[Instrument, ...]
    options: Mapping[str, Mapping[str, Any]]

    def value(self, name: str) -> float:
        """Expected value of a quantity, SI; of static torque and Stribeck speed a usual one."""
        values = self.wheel.values
        if name == "static" and name not in values:
            return USUAL_STATIC * values["coulomb"]
        if name == "stribeck_speed" and name not in values:
            return USUAL_STRIBECK_SPEED
        return values[name]

    def expected(self) -> Wheel:
        """Wheel that the sheet expects."""
        names = ("viscous", "coulomb", "static", "stribeck_speed")
        friction = Stribeck(**{name: self.value(name) for name in names})
        return Wheel(self.value("inertia"), self.value("motor_constant"), friction)

    def breakaway_current(self) -> float:
        """Current at which the expected wheel breaks away, A."""
        return self.value("static") / self.value("motor_constant")

    def tolerances(self) -> dict[str, float]:
        """Relative sigma of the inertia and of the instruments' scales, as for `identify`."""
        names = {"current": "current_scale", "speed": "speed_scale", "time": "clock"}
        scales = {"inertia": self.bench.inertia_sigma}
        scales |= {
            names[i.quantity]: i.uncertainty for i in self.instruments if i.quantity in names
        }
        return {name: sigma for name, sigma in scales.items() if sigma > 0.0}

    def inertial_scale(self) -> float:
        """Relative sigma of a torque that is inertia times the measured acceleration."""
        scales = self.tolerances()
        clock = 2.0 * scales.get("clock", 0.0)
        return math.hypot(scales.get("inertia", 0.0), scales.get("speed_scale", 0.0), clock)


def read_bench_sheet(path: Path) -> BenchSheet:
    """Read a spec sheet.

    Raises:
        InputError: The file cannot be read, a key or value is not possible, or a quantity that the
            plan needs is missing.
    """
    sheet = read_wheel_sheet(path, partial=True, other=OTHER_TABLES)
    content = read_toml(path, "a spec sheet")
    for name in NEEDED:
        if name not in sheet.values:
            raise InputError(f"{path}: key {name}: found no value, expected the expected one")
    table = _table(path, "bench", content.get("bench"))
    bench = Bench(**read_options(path, "bench", table, Bench, required=True))
    rows = content.get("instrument", [])
    if not isinstance(rows, list):
        raise InputError(f"{path}: key instrument: found {rows!r}, expected tables [[instrument]]")
    instruments = tuple(_instrument(path, f"instrument[{k}]", row) for k, row in enumerate(rows))
    quantities = [each.quantity for each in instruments]
    for name in quantities:
        if quantities.count(name) > 1:
            raise InputError(f"{path}: instrument: found two of {name}, expected one")
    tests = _table(path, "test", content.get("test", {}))
    options = {name: _table(path, f"test.{name}", each) for name, each in tests.items()}
    result = BenchSheet(path, sheet, bench, instruments, options)
    _check(result)
    return result


def _check(sheet: BenchSheet) -> None:
    """Refuse a sheet that no test can serve."""
    bench, where = sheet.bench, f"{sheet.path}: key bench"
    for name, least in (("rate", LEAST_RATE), ("fast_rate", bench.rate)):
        if not least <= getattr(bench, name) <= LARGEST_RATE:
            raise InputError(
                f"{where}.{name}: found {getattr(bench, name):g} Hz, expected {least:g} to "
                f"{LARGEST_RATE:g} Hz"
            )
    fastest = sheet.value("speed_limit")
    for limit in sheet.wheel.limits:
        if limit.conditions.get("speed", 0.0) > fastest:
            raise InputError(
                f"{sheet.path}: key {limit.quantity}.speed: found {limit.conditions['speed']:.3g} "
                f"rad/s, expected at most the speed_limit of {fastest:.3g} rad/s"
            )
    if sheet.value("static") < sheet.value("coulomb"):
        raise InputError(
            f"{sheet.path}: key static: found {sheet.value('static'):g} N·m, expected at least the "
            f"Coulomb torque of {sheet.value('coulomb'):g} N·m"
        )
    least = 2.0 * sheet.breakaway_current()
    if bench.current_limit < least:
        raise InputError(
            f"{where}.current_limit: found {bench.current_limit:g} A, expected at least "
            f"{least:.3g} A, twice the breakaway current"
        )


def _table(path: Path, key: str, value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{path}: key {key}: found {value!r}, expected a table [{key}]")
    return value


def _instrument(path: Path, where: str, row: object) -> Instrument:
    """Read one table [[instrument]]."""
    table = _table(path, where, row)
    refuse_unknown(path, f"{where}.", table, tuple(each.name for each in fields(Instrument)))
    if table.get("quantity") not in MEASURED:
        raise InputError(
            f"{path}: key {where}.quantity: found {table.get('quantity')!r}, expected one of "
            f"{', '.join(MEASURED)}"
        )
    texts = {
        name: name_text(path, f"{where}.{name}", table.get(name, "" if name != "name" else None))
        for name in ("quantity", "name", "serial", "certificate")
    }
    calibrated = _date(path, f"{where}.calibrated", table.get("calibrated"))
    due = _date(path, f"{where}.due", table.get("due"))
    if calibrated is not None and due is not None and due < calibrated:
        raise InputError(f"{path}: key {where}.due: found {due}, expected it after {calibrated}")
    uncertainty = share(path, f"{where}.uncertainty", table.get("uncertainty", 0.0))
    return Instrument(**texts, uncertainty=uncertainty, calibrated=calibrated, due=due)


def _date(path: Path, key: str, value: object) -> datetime.date | None:
    """Date of TOML, or as text."""
    if value is None or (
        isinstance(value, datetime.date) and not isinstance(value, datetime.datetime)
    ):
        return value
    try:
        return datetime.date.fromisoformat(str(value))
    except ValueError:
        raise InputError(
            f"{path}: key {key}: found {value!r}, expected a date such as 2026-03-01"
        ) from None
