"""Verdict on the records of bench tests: measured values against the limits of the sheet."""

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.views import lines
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet, Instrument
from gyrostat.identification.bench_tests.bench_test import BenchTest, Motor, Outcome, PlannedRecord
from gyrostat.identification.bench_tests.plan import chosen_tests
from gyrostat.identification.bench_tests.profile_match import require_profile
from gyrostat.identification.bench_tests.rehearsal import sheet_motor
from gyrostat.identification.judge.acceptance_lines import (
    NO_LIMIT,
    NOT_JUDGED,
    Acceptance,
    Line,
)
from gyrostat.telemetry import Record
from gyrostat.wheel.sheet_limits import Limit

MOTOR_TEST = "torque-speed"
"""Test that gives the motor constant to the others."""


@dataclass(frozen=True)
class RecordFile(Described):
    """Record of a bench with its file.

    Attributes:
        record: The record.
        name: Name of the file.
        digest: SHA-256 of the file, hexadecimal.
    """

    record: Record
    name: str
    digest: str

    def remark(self, name: str) -> str:
        """Comment of the file: serial, date, operator or temperature; empty without one."""
        return str(self.record.metadata.get(name, ""))


@dataclass(frozen=True)
class TestResult(Described):
    """Result of one test.

    Attributes:
        test: The test.
        files: Its records; empty if it was not run.
        outcome: What they show; None without a result.
        why: Reason why there is no result; empty if there is one.
    """

    __test__ = False  # no test of pytest

    test: BenchTest
    files: tuple[RecordFile, ...]
    outcome: Outcome | None
    why: str = ""


@dataclass(frozen=True, repr=False)
class BenchVerdict(Pictured):
    """Verdict on the tests of one wheel.

    Attributes:
        sheet: Spec sheet.
        results: Results of all tests, in their order.
        acceptance: Lines in the order of the sheet.
        sources: Name of the test that gave each line; empty without one.
        serial: Serial number of the wheel; empty if the records have none.
    """

    sheet: BenchSheet
    results: tuple[TestResult, ...]
    acceptance: Acceptance
    sources: tuple[str, ...]
    serial: str

    @property
    def files(self) -> list[RecordFile]:
        """All records."""
        return [file for result in self.results for file in result.files]

    def __repr__(self) -> str:
        """Table that the command line prints."""
        return "\n".join(lines(self))


def record_names(sheet: BenchSheet, names: Sequence[str]) -> dict[str, list[str]]:
    """Names of the records of each test.

    Raises:
        InputError: A test is unknown, or the bench cannot run it.
    """
    return {name: [r.name for r in records] for name, records in _planned(sheet, names).items()}


def _planned(sheet: BenchSheet, names: Sequence[str]) -> dict[str, list[PlannedRecord]]:
    """Planned records of each test."""
    tests = chosen_tests(sheet, names, "tests")
    return {name: test.records(sheet) for name, test in tests.items()}


def judge_tests(
    sheet: BenchSheet, names: Sequence[str], files: Mapping[str, RecordFile]
) -> BenchVerdict:
    """Judge a wheel by the records of its tests.

    Args:
        sheet: Spec sheet.
        names: Names of the tests; "all" for every one.
        files: Name of a record -> its file.

    Raises:
        InputError: The records are of several wheels, a record does not contain the current that
            its test asked for, or a name is unknown.
    """
    serial = _one_serial(files)
    _require_distinct(files)
    tests = chosen_tests(sheet, names, "tests")
    planned = _planned(sheet, names)
    _require_profiles(planned, files)
    wanted = {name: [each.name for each in records] for name, records in planned.items()}
    motor, results = sheet_motor(sheet), {}
    for name in sorted(tests, key=lambda name: name != MOTOR_TEST):
        results[name] = _evaluated(sheet, tests[name], wanted[name], files, motor)
        if name == MOTOR_TEST:
            motor = _identified(results[name], motor)
    ordered = tuple(results[name] for name in tests)
    judged_lines, sources = [], []
    for limit in sheet.wheel.limits:
        if not limit.limited:
            continue
        for line, source in _lines(limit, ordered, wanted, sheet.instruments):
            judged_lines.append(line)
            sources.append(source)
    notes = tuple(_without_serial(files))
    notes += tuple(f"no calibration of the {q} is stated" for q in _unstated(sheet.instruments))
    acceptance = Acceptance(sheet.wheel.name, tuple(judged_lines), notes)
    return BenchVerdict(sheet, ordered, acceptance, tuple(sources), serial)


def _require_profiles(
    planned: Mapping[str, Sequence[PlannedRecord]], files: Mapping[str, RecordFile]
) -> None:
    """Require that each record contains the current of its own profile."""
    every = [each for records in planned.values() for each in records]
    for test, records in planned.items():
        for each in records:
            if each.name in files:
                file, others = files[each.name], [other for other in every if other is not each]
                require_profile(file.record, file.name, test, each, others)


def _one_serial(files: Mapping[str, RecordFile]) -> str:
    """Serial number that all records share; empty if none has one."""
    serials = {name: file.remark("serial") for name, file in files.items()}
    stated = {serial: name for name, serial in serials.items() if serial}
    if len(stated) > 1:
        found = ", ".join(f"{serial} ({name})" for serial, name in sorted(stated.items()))
        raise InputError(f"records: found serial numbers {found}, expected those of one wheel")
    return next(iter(stated), "")


def _without_serial(files: Mapping[str, RecordFile]) -> list[str]:
    """Remark on records without a serial number."""
    without = [file.name for file in files.values() if not file.remark("serial")]
    if not without:
        return []
    who = "the records state" if len(without) == len(files) else f"{', '.join(without)}: found"
    return [f"{who} no serial number (a comment # serial: ...)"]


def _require_distinct(files: Mapping[str, RecordFile]) -> None:
    """Require that no file stands for two records."""
    names: dict[str, str] = {}
    for file in files.values():
        other = names.setdefault(file.digest, file.name)
        if other != file.name:
            raise InputError(
                f"records: found the same content in {other} and {file.name}, expected a record of "
                "its own for each"
            )


def _unstated(instruments: Sequence[Instrument]) -> list[str]:
    stated = {each.quantity for each in instruments if each.due is not None}
    return [name for name in ("current", "speed") if name not in stated]


def _evaluated(
    sheet: BenchSheet,
    test: BenchTest,
    names: Sequence[str],
    files: Mapping[str, RecordFile],
    motor: Motor,
) -> TestResult:
    """Result of one test."""
    present = tuple(files[name] for name in names if name in files)
    if len(present) < len(names):
        missing = [name for name in names if name not in files]
        return TestResult(test, present, None, f"not run: no record {', '.join(missing)}")
    try:
        with np.errstate(all="ignore"):
            outcome = test.evaluate(sheet, [file.record for file in present], motor)
    except InputError as error:
        return TestResult(test, present, None, f"no result: {error}")
    return TestResult(test, present, outcome)


def _identified(result: TestResult, motor: Motor) -> Motor:
    """Motor constant of the test that identifies it; that of the sheet without one."""
    values = () if result.outcome is None else result.outcome.values
    for each in values:
        if each.quantity == "motor_constant":
            return Motor(each.value, each.sigma, f"the motor constant of {MOTOR_TEST}")
    return motor


def _lines(
    limit: Limit,
    results: Sequence[TestResult],
    wanted: Mapping[str, Sequence[str]],
    instruments: Sequence[Instrument],
) -> list[tuple[Line, str]]:
    """Lines on one limit with the test that gave them: the first one that measured it."""
    reasons = []
    undecided: list[tuple[Line, str]] = []
    for result in results:
        if limit.quantity not in result.test.quantities:
            continue
        if result.outcome is None:
            reasons.append(result.why)
            continue
        found = result.outcome.of(limit)
        lapsed = [_lapsed(file, instruments) for file in result.files]
        why = next((reason for reason in lapsed if reason), "")
        if why:
            found = [replace(line, verdict=NOT_JUDGED, why=why) for line in found]
        pairs = [(line, result.test.name) for line in found]
        if found and all(line.verdict not in (NOT_JUDGED, NO_LIMIT) for line in found):
            return pairs
        undecided = undecided or pairs
    if undecided:
        return undecided
    no_test = "no test of this plan measures it"
    if limit.quantity in ("static_imbalance", "dynamic_imbalance"):
        no_test = "a record of current and speed does not show it"
    why = "; ".join(dict.fromkeys(reasons)) or no_test
    return [(Line(limit, 0, None, None, NOT_JUDGED, why), "")]


def _lapsed(file: RecordFile, instruments: Sequence[Instrument]) -> str:
    """Reason why an instrument of a record was not calibrated at its date; empty if all were."""
    date = record_date(file)
    used = {"current", "speed", "time"}
    used |= {name for name in ("temperature", "torque") if getattr(file.record, name) is not None}
    for each in instruments:
        if each.quantity not in used or (each.due is None and each.calibrated is None):
            continue
        if date is None:
            stated = file.remark("date") or "none"
            return (
                f"found {stated} as the date of the record, expected one as 2026-05-31: the "
                f"calibration of {each.name} is judged by it"
            )
        if each.due is not None and date > each.due:
            return f"the calibration of {each.name} was due on {each.due}, the record is of {date}"
        if each.calibrated is not None and date < each.calibrated:
            return f"{each.name} was calibrated on {each.calibrated}, the record is of {date}"
    return ""


def record_date(file: RecordFile) -> datetime.date | None:
    """Date of a record; None if it states none that is a date."""
    try:
        return datetime.date.fromisoformat(file.remark("date")[:10])
    except ValueError:
        return None
