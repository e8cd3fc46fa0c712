"""Plan of bench tests from a spec sheet."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gyrostat.core.errors import InputError
from gyrostat.core.pictured import Described, Pictured
from gyrostat.core.views import lines
from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
from gyrostat.identification.bench_tests.bench_test import BenchTest, PlannedRecord, bench_tests
from gyrostat.identification.bench_tests.rehearsal import Rehearsal, rehearse

MOST_RUNS = 10_000


@dataclass(frozen=True)
class PlannedTest(Described):
    """One test of a plan.

    Attributes:
        test: The test with its options.
        records: Its records.
        rehearsal: What it determines, by simulation; None if it was not simulated.
    """

    test: BenchTest
    records: tuple[PlannedRecord, ...]
    rehearsal: Rehearsal | None


@dataclass(frozen=True, repr=False)
class TestPlan(Pictured):
    """Plan of bench tests.

    Attributes:
        sheet: Spec sheet.
        tests: Tests in their order.
        seed: Seed of the simulation.
    """

    __test__ = False  # no test of pytest

    sheet: BenchSheet
    tests: tuple[PlannedTest, ...]
    seed: int

    @property
    def duration(self) -> float:
        """Duration of all records, s."""
        return sum(record.duration for each in self.tests for record in each.records)

    def __repr__(self) -> str:
        """Table that the command line prints."""
        return "\n".join(lines(self))


def chosen_tests(sheet: BenchSheet, names: Sequence[str], where: str) -> dict[str, BenchTest]:
    """Tests by name; "all" for every one.

    Raises:
        InputError: A name is unknown.
    """
    every = bench_tests(sheet)
    for name in names:
        if name not in ("all", *every):
            raise InputError(f"{where}: found {name!r}, expected all, or of {', '.join(every)}")
    return {name: each for name, each in every.items() if "all" in names or name in names}


def plan_tests(
    sheet: BenchSheet,
    names: Sequence[str],
    *,
    runs: int = 0,
    seed: int = 0,
    say: Callable[[str], None] = lambda line: None,
) -> TestPlan:
    """Plan tests of a wheel.

    Args:
        sheet: Spec sheet.
        names: Names of tests; "all" for every one.
        runs: Number of simulated tests of each kind; 0: no prediction.
        seed: Seed of the simulation.
        say: Function that receives progress.

    Raises:
        InputError: A name is unknown, or the bench cannot run a test.
    """
    if not 0 <= runs <= MOST_RUNS:
        raise InputError(f"simulate: found {runs}, expected 0 to {MOST_RUNS}")
    designs = [
        (test, tuple(test.records(sheet))) for test in chosen_tests(sheet, names, "tests").values()
    ]
    tests = []
    for test, records in designs:
        rehearsal = None
        if runs:
            say(f"simulating {test.name}")
            rehearsal = rehearse(sheet, test, records, runs, seed, say)
        tests.append(PlannedTest(test, records, rehearsal))
    return TestPlan(sheet, tuple(tests), seed)
