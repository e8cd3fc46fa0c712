"""Tests that a bench runs: designs, estimates against closed solutions, verdicts, files."""

import hashlib
import json
import re
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat.core.errors import InputError
from gyrostat.core.text import measured as measured_text
from gyrostat.core.units import RPM
from gyrostat.identification.bench_tests.bench_sheet import read_bench_sheet
from gyrostat.identification.bench_tests.bench_test import (
    Measured,
    Motor,
    Outcome,
    bench_tests,
)
from gyrostat.identification.bench_tests.change_point import breakaway
from gyrostat.identification.bench_tests.coasting import Coasted, coast_friction
from gyrostat.identification.bench_tests.kinds.breakaway import rises
from gyrostat.identification.bench_tests.kinds.run_in import RunIn
from gyrostat.identification.bench_tests.kinds.thermal_vacuum import ThermalVacuum
from gyrostat.identification.bench_tests.kinds.torque_noise import TorqueNoise
from gyrostat.identification.bench_tests.kinds.zero_crossing import acceleration_steps
from gyrostat.identification.bench_tests.program import Program
from gyrostat.identification.bench_tests.rehearsal import rehearse, simulated
from gyrostat.identification.bench_tests.repetitions import (
    largest_of,
    mean_of,
    scatter_of,
    size_of,
)
from gyrostat.identification.bench_tests.spectrum import spectrum
from gyrostat.identification.judge.acceptance_lines import FAIL, NOT_JUDGED, PASS
from gyrostat.telemetry import Record, write_record
from gyrostat.wheel import speed_response
from gyrostat.wheel.uneven_wheel import Ripple, uneven_speeds

pytestmark = pytest.mark.optimised
SHEET = """name = "RW-1"
[inertia]
value = 1.5e-3
source = "drawing"
[motor_constant]
value = 0.0228
tolerance = "3 %"
source = "spec 1"
[coulomb]
value = "0.88 mN·m"
source = "first"
[viscous]
value = 4.83e-6
source = "first"
[speed_limit]
value = "400 rpm"
source = "spec 2"
[[loss_torque]]
speed = "300 rpm"
maximum = "1.2 mN·m"
source = "spec 3"
[torque_ripple]
maximum = "0.05 mN·m"
source = "spec 4"
[bench]
current_limit = "0.15 A"
speed_sigma = "0.3 rpm"
rate = "10 Hz"
fast_rate = "50 Hz"
ripple = 0
drift = 0
"""


@pytest.fixture
def sheet_file(tmp_path):
    def write(change=lambda text: text):
        path = tmp_path / "sheet.toml"
        path.write_text(change(SHEET), encoding="utf-8")
        return path

    return write


@pytest.fixture
def sheet(sheet_file):
    return read_bench_sheet(sheet_file())


def record_of(time, current, speed, name="record"):
    return Record(name, time, current, speed, np.ones(len(time), dtype=bool))


def test_an_even_wheel_moves_as_by_the_exact_response(sheet):
    wheel = sheet.expected()
    time = np.arange(401) / 10.0
    current = np.where(time < 12.0, 0.06, np.where(time < 20.0, -0.06, 0.0))
    none = Ripple(*np.zeros((3, 1, 1)))
    speed = uneven_speeds(wheel, time, current, np.ones((1, 401)), none)[0]
    exact = np.asarray(speed_response(wheel, time, current, 0.0)[0])
    np.testing.assert_allclose(speed, exact, atol=2e-3)
    assert speed[-1] == 0.0


def test_a_ripple_keeps_a_wheel_at_rest_until_the_current_exceeds_both(sheet):
    wheel = sheet.expected()
    time = np.arange(101) / 10.0
    held = Ripple(np.array([[2e-4]]), np.array([[1.0]]), np.array([[-0.5 * np.pi]]))
    static = sheet.value("static")
    for excess, moves in ((0.99, False), (1.01, True)):
        current = np.full(101, excess * (static + 2e-4) / 0.0228)
        speed = uneven_speeds(wheel, time, current, np.ones((1, 101)), held)
        assert bool(np.any(speed)) is moves


def test_a_programme_reaches_its_speed_when_the_closed_solution_does(sheet):
    program = Program(sheet, "coast-down", 1000.0)
    program.drive(0.1, 30.0)
    _, current = program.series()
    time = (np.count_nonzero(current)) / 1000.0
    drive = 0.0228 * 0.1 - 0.88e-3
    final = drive / 4.83e-6
    reached = final * (1.0 - np.exp(-4.83e-6 * time / 1.5e-3))
    assert reached == pytest.approx(30.0, abs=2e-3)


def test_a_sine_has_its_mean_square_in_its_band():
    """Parseval: half of the squared amplitude; nothing elsewhere."""
    time = np.arange(4096) / 256.0
    result = spectrum(0.3 * np.sin(2.0 * np.pi * 20.0 * time), 256.0, 512)
    assert result.rms(15.0, 25.0)[0] == pytest.approx(0.3 / np.sqrt(2.0), rel=1e-4)
    assert result.rms(60.0, 120.0)[0] < 1e-3


def test_white_noise_has_its_variance_over_all_frequencies():
    noise = 0.02 * np.random.default_rng(3).standard_normal(60_000)
    result = spectrum(noise, 100.0, 400)
    value, sigma = result.rms(0.0, 50.0)
    assert value == pytest.approx(0.02, abs=5.0 * sigma + 1e-4)
    # chi-square with 2 B T degrees of freedom; 3 % more for the ends that few segments contain
    assert sigma == pytest.approx(0.02 * 0.5 / np.sqrt(50.0 * 600.0), rel=0.2)
    level = result.density[10:-10].mean()
    assert level == pytest.approx(2.0 * 0.02**2 / 100.0, rel=0.02)


def test_the_breakaway_is_found_with_its_scatter():
    random = np.random.default_rng(4)
    time = np.arange(200) / 10.0
    errors, sigmas = [], []
    for _ in range(120):
        start = random.uniform(8.0, 9.0)
        after = np.maximum(time - start, 0.0)
        speed = 0.3 * after + 0.1 * after**2 + 0.03 * random.standard_normal(200)
        found = breakaway(time, speed, 0.03)
        errors.append(found.time - start)
        sigmas.append(found.sigma)
    assert abs(np.mean(errors)) < 4.0 * np.std(errors) / np.sqrt(120.0)
    assert np.std(errors) == pytest.approx(np.sqrt(np.mean(np.square(sigmas))), rel=0.25)
    assert breakaway(time, 0.03 * random.standard_normal(200), 0.03) is None


def test_bounds_of_few_repetitions_hold_in_95_percent():
    """Student's t for the mean, chi-square for the scatter; binomial error of 6000 sets 0.28 %."""
    draws = np.random.default_rng(5).standard_normal((6000, 5))
    estimates = [(mean_of(d), scatter_of(d)) for d in draws]
    upper = np.array([[e.value + 1.644854 * e.guard for e in pair] for pair in estimates])
    assert np.mean(upper[:, 0] < 0.0) == pytest.approx(0.05, abs=0.01)
    assert np.mean(upper[:, 1] < 1.0) == pytest.approx(0.05, abs=0.01)


@pytest.mark.parametrize("noise", [0.0, 1.2])
@pytest.mark.parametrize("shape", ["normal", "uniform"])
def test_a_scatter_has_the_sigma_of_its_own_scatter(shape, noise):
    random = np.random.default_rng(15)
    size = (1500, 12)
    true = random.standard_normal(size) if shape == "normal" else random.uniform(-1.7, 1.7, size)
    draws = true + noise * random.standard_normal(size)
    values, sigmas, _ = np.array([scatter_of(each, noise) for each in draws]).T
    assert np.median(sigmas) == pytest.approx(np.std(values), rel=0.15)


@pytest.mark.parametrize("true", [0.0, 3.0])
def test_the_size_of_a_value_near_zero_scatters_less(true):
    draws = true + np.random.default_rng(16).standard_normal(4000)
    values, sigmas, guards = np.array([size_of(each, 1.0, 1.2) for each in draws]).T
    assert np.median(sigmas) == pytest.approx(np.std(values), rel=0.1)
    assert np.all(guards == 1.2)


@pytest.mark.parametrize("true", [(0.0, 0.0, 0.0, 0.0), (0.0, 9.0, 0.0, 9.0), (0.0, 0.0, 0.0, 9.0)])
def test_the_largest_of_several_is_not_too_large(true):
    random = np.random.default_rng(17)
    draws = np.array(true) + random.standard_normal((400, 4))
    results = np.array([largest_of(d, np.ones(4), [0, 1, 0, 1]) for d in draws])
    values, sigmas, guards = results.T
    # the largest of four equal values is 1.03 too large
    assert abs(values.mean() - max(true)) < 0.5
    assert np.median(sigmas) == pytest.approx(np.std(values), rel=0.3)
    for side in (1.0, -1.0):
        assert np.mean(side * (values - max(true)) > 1.644854 * guards) < 0.08


def test_a_wheel_at_its_limit_passes_and_fails_in_five_percent_each(sheet):
    (limit,) = [each for each in sheet.wheel.limits if each.quantity == "torque_ripple"]
    draws = 5e-5 + 1e-6 * np.random.default_rng(6).standard_normal((4000, 8))
    verdicts = [Measured.of("torque_ripple", mean_of(d)).line(limit).verdict for d in draws]
    for verdict in (PASS, FAIL):
        assert np.mean([v == verdict for v in verdicts]) == pytest.approx(0.05, abs=0.011)


def test_the_step_of_acceleration_is_that_of_the_friction():
    time = np.arange(0.0, 40.0, 0.1)
    speed = np.where(time < 15.0, 0.5 * (time - 15.0), 0.2 * (time - 15.0))
    record = record_of(time, np.where(time < 39.0, 0.06, -0.06), speed)
    ((step, sigma, _),) = acceleration_steps(record)
    assert step == pytest.approx(0.3, abs=1e-9)
    assert sigma < 1e-9


def test_rises_are_ramps_and_no_pulses():
    ramp, rest, pulse = np.linspace(0.03, 0.06, 50), np.zeros(20), np.full(30, 0.1)
    current = np.concatenate([rest, ramp, rest, pulse, rest, -ramp, rest])
    assert [(p.start, p.stop) for p in rises(current)] == [(20, 70), (140, 190)]


def test_a_coast_with_drifting_friction_has_errors_as_large_as_its_sigma(sheet):
    """Coasts with random drifts, integrated in fine steps; the drift is estimated with them."""
    step, count, random = 1e-2, 40, np.random.default_rng(2)
    time = np.arange(0.0, 60.0 + 0.5 * step, step)
    share = 2.0 * time / time[-1] - 1.0
    drifts = 0.005 * random.standard_normal(count)
    speed = np.empty((len(time), count))
    speed[0] = 41.0
    for k in range(len(time) - 1):
        growth = 1.0 + drifts * (share[k] + step / time[-1])
        half = speed[k] - 0.5 * step * growth * (4.83e-6 * speed[k] + 0.88e-3) / 1.5e-3
        speed[k + 1] = speed[k] - step * growth * (4.83e-6 * half + 0.88e-3) / 1.5e-3
    measured = speed[::10].T + 0.01 * random.standard_normal((count, len(time[::10])))
    records = [record_of(time[::10], np.zeros(len(w)), w) for w in measured]
    drifting = replace(sheet, bench=replace(sheet.bench, drift=0.005))
    coasts = [coast_friction(drifting, record) for record in records]
    errors = np.array([coast.values - [4.83e-6, 0.88e-3] for coast in coasts])
    sigmas = np.array([np.sqrt(np.diag(coast.covariance)) for coast in coasts])
    # 3 sigma of a root mean square of 40
    np.testing.assert_allclose(np.sqrt(np.mean((errors / sigmas) ** 2, axis=0)), 1.0, atol=0.34)
    exact = 1.5e-3 / 4.83e-6 * np.log1p(4.83e-6 * 30.0 / 0.88e-3)
    times = np.array([coast.time(30.0) for coast in coasts])
    assert np.sqrt(np.mean(((times[:, 0] - exact) / times[:, 1]) ** 2)) == pytest.approx(
        1, abs=0.34
    )
    plain = [coast_friction(sheet, record) for record in records]
    ratios = [(each.values[1] - 0.88e-3) / np.sqrt(each.covariance[1, 1]) for each in plain]
    assert np.std(ratios) > 1.5


def test_the_coast_down_time_has_the_errors_of_speed_scale_and_clock():
    exact = Coasted(np.array([4.83e-6, 0.88e-3]), np.zeros((2, 2)), 1.5e-3, 0.0)
    assert exact.time(30.0)[1] == 0.0
    (time, _), step = exact.time(30.0), 1e-6
    faster = replace(exact, values=exact.values * [1.0, 1.0 + step]).time(30.0)[0]
    scaled = replace(exact, speed_scale=0.01, clock=0.002)
    expected = np.hypot(0.01 * (faster - time) / step, 0.002 * time)
    assert scaled.time(30.0)[1] == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("value = 1.5e-3", "value = 0", "inertia.value: found 0"),
        ('value = "400 rpm"', 'value = "400 s"', "found unit 's'"),
        ("rate = ", "speed = ", "bench.speed: found an unknown key"),
        ('speed_sigma = "0.3 rpm"', "", "bench.speed_sigma: found none"),
        ("ripple = 0\n", 'ripple = "60 %"\n', "expected 0 to 0.5"),
        ("ripple = 0\n", 'ripple = "10"\n', "bench.ripple: found '10', expected 0 to 0.5"),
        ('rate = "10 Hz"', 'rate = "0.1 Hz"', "bench.rate: found 0.1 Hz, expected 1 to 100000"),
        ('fast_rate = "50 Hz"', "fast_rate = 2", "bench.fast_rate: found 2 Hz, expected 10 to"),
        ('tolerance = "3 %"', 'tolerance = "300 %"', "found '300 %', expected less than 100 %"),
        ('speed = "300 rpm"', 'speed = "450 rpm"', "loss_torque.speed: found 47.1 rad/s, expected"),
        ('current_limit = "0.15 A"', "current_limit = 0.01", "twice the breakaway current"),
        ("tolerance =", "minimum = 1\nmaximum = 0.5\ntolerance =", "motor_constant.tolerance"),
        ('maximum = "1.2 mN·m"', "minimum = 2\nmaximum = 1", "expected them in order"),
        ("[bench]", "[test.spin]\n[bench]", "found an unknown test"),
        ("[bench]", "[test.run-in]\ncycles = 1.5\n[bench]", "expected a whole number"),
        ("[bench]", '[[instrument]]\nquantity = "mass"\nname = "x"\n[bench]', "found 'mass'"),
        (
            "[bench]",
            '[[instrument]]\nquantity = "speed"\nname = "x"\ndue = "soon"\n[bench]',
            "expected a date",
        ),
        (
            "[bench]",
            '[[instrument]]\nquantity = "speed"\nname = "x"\ncalibrated = 2026-02-01\n'
            "due = 2026-01-01\n[bench]",
            "expected it after",
        ),
        ('[coulomb]\nvalue = "0.88 mN·m"', '[coulomb]\nmaximum = "1 mN·m"', "key coulomb"),
        ("[bench]", '[static]\nvalue = "0.5 mN·m"\nsource = "x"\n[bench]', "key static"),
    ],
)
def test_a_sheet_that_cannot_be_used_is_refused(sheet_file, old, new, message):
    path = sheet_file(lambda text: text.replace(old, new, 1))
    with pytest.raises(InputError) as error:
        bench_tests(read_bench_sheet(path))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_bench_that_does_not_reach_the_speed_is_named(sheet_file):
    path = sheet_file(lambda text: text.replace("400 rpm", "9000 rpm").replace("0.15", "0.09"))
    with pytest.raises(InputError, match="current_limit"):
        gs.bench(path, tests="coast-down")


def test_every_design_keeps_to_the_current_limit_and_has_a_template(sheet):
    for name, test in bench_tests(sheet).items():
        for record in test.records(sheet):
            assert np.max(np.abs(record.current)) <= sheet.bench.current_limit
            assert record.name.startswith(name)
            assert np.all(np.diff(record.time) > 0.0)


@pytest.fixture
def measured(sheet, tmp_path):
    """Write records of some tests, as a bench does."""

    def measured(names, comment="# serial: RW-1-7\n# date: 2026-05-02\n"):
        folder, random = tmp_path / "records", np.random.default_rng(8)
        folder.mkdir(exist_ok=True)
        for name in names:
            for planned in bench_tests(sheet)[name].records(sheet):
                (record,) = simulated(sheet, planned, 1, random)
                path = folder / f"{planned.name}.csv"
                write_record(record, path)
                path.write_text(comment + path.read_text(encoding="utf-8"), encoding="utf-8")
        return folder

    return measured


def test_plan_records_and_report_from_end_to_end(sheet_file, measured, tmp_path):
    path = sheet_file()
    plan = gs.bench(path, tmp_path / "plan", tests="coast-down,zero-crossing")
    assert [each.test.name for each in plan.tests] == ["coast-down", "zero-crossing"]
    for axes, planned in zip(plan.plot().axes, plan.tests, strict=True):
        record = planned.records[0]
        assert axes.get_title() == record.name
        x, y = axes.get_lines()[0].get_data()
        assert (x[0], x[-1]) == (record.time[0], record.time[-1])
        assert (min(y), max(y)) == (min(record.current), max(record.current))
    assert "data:image/png" in plan._repr_html_()
    template = tmp_path / "plan/records/coast-down-positive.csv"
    assert template.read_text(encoding="utf-8").splitlines()[-1] == "time_s,current_A,speed_rad/s"
    with pytest.raises(InputError, match="no filled record"):
        gs.bench(path, verdict=tmp_path / "plan/records")
    folder = measured(["coast-down", "zero-crossing"])
    lines = []
    verdict = gs.bench(path, tmp_path / "report", verdict=folder, say=lines.append)
    rows = {(x.limit.quantity, x.sense): x for x in verdict.acceptance.lines}
    for sense in (1, -1):
        row = rows["loss_torque", sense]
        assert row.verdict == PASS
        assert row.measured == pytest.approx(0.88e-3 + 4.83e-6 * 300.0 * RPM, abs=4 * row.sigma)
        assert row.sigma < 0.01 * row.measured
    assert rows["torque_ripple", 0].verdict == NOT_JUDGED
    assert "not run: no record breakaway-ramp" in rows["torque_ripple", 0].why
    row = rows["loss_torque", 1]
    titles = [axes.get_title() for axes in verdict.plot().axes if axes.get_visible()]
    panels = [each.outcome.panels[0] for each in verdict.results if each.outcome is not None]
    assert titles[: len(panels)] == [panel.title for panel in panels]
    unit = row.limit.unit
    text = measured_text(row.measured / unit.factor, row.sigma / unit.factor)
    assert re.search(rf" {unit.symbol} +{re.escape(text)} ", unescape(verdict._repr_html_()))
    content = json.loads((tmp_path / "report/acceptance.json").read_text(encoding="utf-8"))
    digest = hashlib.sha256((folder / "coast-down-positive.csv").read_bytes()).hexdigest()
    assert content["records"][0]["sha256"] == digest
    assert content["serial"] == "RW-1-7"
    page = (tmp_path / "report/acceptance.html").read_text(encoding="utf-8")
    document = (tmp_path / "report/acceptance.pdf").read_bytes()
    assert digest in page
    assert "signature" in page
    # one unit for torques, in charts as in tables
    assert {*re.findall(r"\([^()]*N·m\)", page)} == {"(mN·m)"}
    curve = next(p.lines[0][1] for p in panels if p.lines and p.y == "torque (N·m)")
    drawn = verdict.plot().axes[0].lines[0].get_ydata()
    np.testing.assert_allclose(drawn, 1e3 * curve)
    assert '<p class="verdict open">' in page
    assert document.startswith(b"%PDF")
    gs.bench(path, tmp_path / "again", verdict=folder)
    assert (tmp_path / "again/acceptance.pdf").read_bytes() == document
    assert "NOT YET ACCEPTED" in lines[-2]


def test_records_after_the_end_of_a_calibration_are_not_judged(sheet_file, measured):
    instrument = '[[instrument]]\nquantity = "current"\nname = "shunt"\ndue = 2026-05-01\n[bench]'
    path = sheet_file(lambda text: text.replace("[bench]", instrument))
    verdict = gs.bench(path, verdict=measured(["coast-down"]))
    (first, *_) = [x for x in verdict.acceptance.lines if x.limit.quantity == "loss_torque"]
    assert first.verdict == NOT_JUDGED
    assert "calibration of shunt" in first.why


@pytest.mark.parametrize(
    ("comment", "reason"),
    [
        ("# serial: RW-1-7\n", "found none as the date"),
        ("# serial: RW-1-7\n# date: 2.5.2026\n", "found 2.5.2026 as the date"),
        ("# serial: RW-1-7\n# date: 2026-05-02\n", "was calibrated on 2026-06-01"),
    ],
)
def test_a_calibration_that_is_not_shown_to_hold_is_no_pass(sheet_file, measured, comment, reason):
    instrument = (
        '[[instrument]]\nquantity = "current"\nname = "shunt"\n'
        "calibrated = 2026-06-01\ndue = 2027-05-01\n[bench]"
    )
    path = sheet_file(lambda text: text.replace("[bench]", instrument))
    verdict = gs.bench(path, verdict=measured(["coast-down"], comment=comment))
    (first, *_) = [x for x in verdict.acceptance.lines if x.limit.quantity == "loss_torque"]
    assert first.verdict == NOT_JUDGED
    assert reason in first.why


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda rows: [rows[0].replace("speed_rad/s", "temperature_degC"), *rows[1:]], "speed"),
        (lambda rows: [rows[0].replace("rad/s", "parsec"), *rows[1:]], "unit"),
        (lambda rows: [rows[0], *rows[1:50], "nan,0,0", *rows[50:]], "row"),
        (lambda rows: [rows[0], *rows[:0:-1]], "expected strictly increasing time"),
    ],
)
def test_a_spoilt_record_is_refused_in_one_line(sheet_file, measured, change, message):
    folder = measured(["coast-down"], comment="")
    path = folder / "coast-down-positive.csv"
    rows = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join(change(rows)) + "\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        gs.bench(sheet_file(), verdict=folder)
    assert "coast-down-positive.csv" in str(error.value)
    assert message in str(error.value)


def test_records_of_two_wheels_are_refused(sheet_file, measured):
    folder = measured(["coast-down"])
    path = folder / "coast-down-negative.csv"
    path.write_text(path.read_text(encoding="utf-8").replace("RW-1-7", "RW-1-8"), encoding="utf-8")
    with pytest.raises(InputError, match="expected those of one wheel"):
        gs.bench(sheet_file(), verdict=folder)


def test_one_file_for_two_records_is_refused(sheet_file, measured):
    folder = measured(["coast-down"])
    first, second = (folder / f"coast-down-{word}.csv" for word in ("positive", "negative"))
    second.write_bytes(first.read_bytes())
    with pytest.raises(InputError, match="the same content in coast-down-positive"):
        gs.bench(sheet_file(), verdict=folder)


def test_a_record_without_the_serial_number_of_the_others_is_named(sheet_file, measured):
    folder = measured(["coast-down"])
    path = folder / "coast-down-negative.csv"
    text = path.read_text(encoding="utf-8").replace("# serial: RW-1-7\n", "")
    path.write_text(text, encoding="utf-8")
    notes = gs.bench(sheet_file(), verdict=folder).acceptance.notes
    assert any(note.startswith("coast-down-negative.csv: found no serial number") for note in notes)


def test_swapped_records_are_refused_without_a_report(sheet_file, measured, tmp_path):
    folder = measured(["coast-down"])
    first, second = (folder / f"coast-down-{word}.csv" for word in ("positive", "negative"))
    first.rename(folder / "other")
    second.rename(first)
    (folder / "other").rename(second)
    with pytest.raises(InputError) as error:
        gs.bench(sheet_file(), tmp_path / "report", verdict=folder)
    assert str(error.value) == (
        "coast-down-positive.csv: test coast-down: found the current of coast-down-negative, "
        "expected that of profiles/coast-down-positive.csv"
    )
    assert not (tmp_path / "report").exists()


def test_a_record_without_the_test_gives_no_result(sheet, sheet_file, measured):
    folder = measured(["coast-down"])
    (planned, _) = bench_tests(sheet)["coast-down"].records(sheet)
    short = np.count_nonzero(planned.current) + 8
    time = planned.time[:short]
    cut = record_of(time, planned.current[:short], 3.0 * time)
    write_record(cut, folder / "coast-down-positive.csv")
    verdict = gs.bench(sheet_file(), verdict=folder)
    assert verdict.results[0].why.startswith("no result: coast-down-positive.csv: found no coast")
    assert verdict.results[0].outcome is None


def test_breakaways_at_several_angles_give_the_static_torque(sheet):
    test = bench_tests(sheet)["breakaway"]
    random = np.random.default_rng(9)
    records = [simulated(sheet, planned, 1, random)[0] for planned in test.records(sheet)]
    outcome = test.evaluate(sheet, records, Motor(0.0228, 0.0, "exact"))
    for each in outcome.values:
        if each.quantity == "static":
            # half a step of the staircase
            assert each.value == pytest.approx(sheet.value("static"), rel=0.02)


def test_a_loss_torque_that_grows_is_the_slope_per_hour(sheet):
    test = RunIn(cycles=6, hold_time=60.0)
    (planned,) = test.records(sheet)
    growth = 1.0 + 0.2 * planned.time / 3600.0
    none = Ripple(*np.zeros((3, 1, 1)))
    speed = uneven_speeds(sheet.expected(), planned.time, planned.current, growth[None], none)[0]
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(speed))
    record = record_of(planned.time, planned.current, speed + noise)
    (change,) = test.evaluate(sheet, [record], Motor(0.0228, 0.0, "exact")).values
    loss = 0.88e-3 + 4.83e-6 * 0.7 * 200.0 * RPM
    assert change.value == pytest.approx(0.2 * loss, rel=0.1)


def test_thermal_records_need_a_temperature(sheet):
    test = ThermalVacuum(cycles=1, speed=20.0)
    time = np.arange(50) / 10.0
    record = record_of(time, np.zeros(50), np.linspace(20.0, 10.0, 50))
    with pytest.raises(InputError, match="found no temperature"):
        test.evaluate(sheet, [record, record], Motor(0.0228, 0.0, "exact"))


def test_a_plateau_at_another_temperature_is_no_result(sheet):
    test = ThermalVacuum(cycles=1, speed=20.0)
    time = np.arange(50) / 10.0
    record = replace(
        record_of(time, np.zeros(50), np.linspace(20.0, 10.0, 50)), temperature=np.full(50, 20.0)
    )
    with pytest.raises(InputError, match=r"found 20.0 to 20.0 °C, expected the plateau of -10 °C"):
        test.evaluate(sheet, [record, record], Motor(0.0228, 0.0, "exact"))
    # with the right mean
    record = replace(record, temperature=np.linspace(-34.0, 14.0, 50))
    with pytest.raises(InputError, match=r"found -34.0 to 14.0 °C"):
        test.evaluate(sheet, [record, record], Motor(0.0228, 0.0, "exact"))


@pytest.fixture
def fast(sheet):
    """The test of the torque noise, and its records with a column of the torque."""
    test = TorqueNoise(hold_time=20.0)
    random = np.random.default_rng(11)
    records = []
    for planned in test.records(sheet):
        (record,) = simulated(sheet, planned, 1, random)
        torque = sheet.value("inertia") * np.gradient(np.nan_to_num(record.speed), record.time)
        records.append(replace(record, torque=torque))
    return test, records


def test_a_torque_that_is_not_that_of_the_acceleration_is_noted(sheet, fast):
    """A piezoelectric sensor shows no slow torques; noise of the speed is no difference."""
    test, records = fast
    motor, random = Motor(0.0228, 0.0, "exact"), np.random.default_rng(3)
    noisy = [replace(r, speed=r.speed + random.normal(0.0, 0.3, r.speed.shape)) for r in records]
    assert not any("while the wheel" in n for n in test.evaluate(sheet, noisy, motor).notes)
    quick = [replace(r, torque=random.normal(0.0, 1e-4, r.torque.shape)) for r in records]
    assert any("while the wheel" in n for n in test.evaluate(sheet, quick, motor).notes)


@pytest.mark.parametrize("scale", [1e-3, 1e3, -1e3])
def test_a_torque_in_another_unit_is_no_result(sheet, fast, scale):
    test, records = fast
    records = [replace(record, torque=scale * record.torque) for record in records]
    with pytest.raises(InputError, match="times inertia times acceleration while the wheel"):
        test.evaluate(sheet, records, Motor(0.0228, 0.0, "exact"))


def test_an_offset_of_the_torque_sensor_is_no_wrong_unit(sheet, fast):
    test, records = fast
    offset = [replace(record, torque=record.torque + 20e-3) for record in records]
    motor = Motor(0.0228, 0.0, "exact")
    assert not any("while the wheel" in n for n in test.evaluate(sheet, offset, motor).notes)


@pytest.mark.parametrize("scale", [-1.0, 9.55, 0.105])
def test_a_coast_with_the_wrong_sign_or_unit_of_the_speed_is_no_result(sheet, scale):
    test, random = bench_tests(sheet)["coast-down"], np.random.default_rng(9)
    records = [simulated(sheet, planned, 1, random)[0] for planned in test.records(sheet)]
    records[0] = replace(records[0], speed=scale * records[0].speed)
    with pytest.raises(InputError, match="in the positive sense, expected about 400 rpm"):
        test.evaluate(sheet, records, Motor(0.0228, 0.0, "exact"))


def test_a_torque_without_noise_is_no_result(sheet, fast):
    test, records = fast
    records = [replace(record, torque=0.0 * record.torque) for record in records]
    with pytest.raises(InputError, match="found a torque of 0 N·m throughout"):
        test.evaluate(sheet, records, Motor(0.0228, 0.0, "exact"))


def test_a_coast_that_is_driven_to_its_end_is_too_short_for_a_spectrum(sheet, fast):
    test, (steady, coast) = fast
    driven = replace(coast, current=np.full_like(coast.current, 0.1))
    with pytest.raises(InputError, match="found 0 s for the spectrum"):
        test.evaluate(sheet, [steady, driven], Motor(0.0228, 0.0, "exact"))


def test_a_value_that_is_judged_too_counts_once_in_a_simulated_test(sheet):
    value = Measured("loss_torque", 1e-3, 1e-5, 1, {"speed": 100.0})
    outcome = Outcome((value,), lines=(value.line(),))

    class Both(type(bench_tests(sheet)["coast-down"])):
        def evaluate(self, sheet, records, motor):
            return outcome

    test = Both()
    (planned, _) = test.records(sheet)
    result = rehearse(sheet, test, [planned], 3, 0, lambda line: None)
    assert [(each.title, each.count) for each in result.predictions] == [(value.line().title, 3)]


def test_a_motor_constant_with_one_limit_converts_no_currents(sheet_file, measured):
    for tolerance in ("minimum = 0.0221", ""):
        path = sheet_file(lambda text, new=tolerance: text.replace('tolerance = "3 %"', new))
        verdict = gs.bench(path, verdict=measured(["breakaway"]))
        (line,) = [x for x in verdict.acceptance.lines if x.limit.quantity == "torque_ripple"]
        assert line.verdict == NOT_JUDGED
        assert "without limits on both sides" in line.why


def test_the_example_sheet_is_read():
    sheet = read_bench_sheet(Path(__file__).parents[2] / "examples/bench_tests.toml")
    assert sheet.tolerances()["inertia"] == pytest.approx(0.003)
