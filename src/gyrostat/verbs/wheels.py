"""Verbs on a known wheel: validate, bench."""

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import (
    Named,
    Quantity,
    Say,
    named,
    one_of,
    refuse_given,
    silent,
)
from gyrostat.verbs.bench_record import bench_record_file
from gyrostat.verbs.bench_tests import changed_options, judge_bench, plan_bench
from gyrostat.verbs.design import design as design_bench
from gyrostat.verbs.wheel_arguments import HOLDS, load_records, parameters_in_si, wheel_model

if TYPE_CHECKING:
    from gyrostat.identification import Fit, Validation
    from gyrostat.identification.bench_tests.plan import TestPlan
    from gyrostat.identification.bench_tests.verdict import BenchVerdict
    from gyrostat.identification.experiment.design import Design
    from gyrostat.telemetry import Record
    from gyrostat.wheel import Wheel, WheelModel, WheelSheet
    from gyrostat.wheel.friction import Friction


def validate(
    model: "WheelModel | Wheel | Fit | str | Path",
    record: "Record | str | Path",
    out: "str | Path | None" = None,
    *,
    sheet: "WheelSheet | str | Path | None" = None,
    hold: Named = None,
    current_hold: str = "zero-order",
    columns: Mapping[str, str] | str | Path | None = None,
    units: Mapping[str, str] | str | None = None,
    unsigned_current: bool = False,
    unsigned_speed: bool = False,
    missing: str = "refuse",
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.validate",
) -> "Validation":
    """Predict an independent record with a known wheel.

    Args:
        model: Wheel, its model, an identification, or path of model.toml.
        record: Record that the model was not fitted to, or its path.
        out: Folder for validation.json and validation.html; None writes no file.
        sheet: Data sheet with acceptance limits: a sheet, its path, or the name of one in the
            package.
        hold: {"current_bias": value}, offset of the drive, A.
        current_hold: Current between samples: "zero-order" or "linear".
        columns: Role -> column of the file, or a .toml file of them.
        units: Role -> unit, if the file has none.
        unsigned_current: Whether the current is a magnitude.
        unsigned_speed: Whether the speed is a magnitude; the sign changes where it touches zero.
        missing: Treatment of cells without a number: "refuse" raises an error, "drop" omits their
            rows.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Residuals, the fraction of samples inside the prediction interval and the verdict `holds`;
        with a sheet, the `acceptance` line by line. The result is valid if it has `converged`.

    Raises:
        InputError: A model, record or sheet cannot be used, or existing files would be replaced.
    """
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.core.views import lines
    from gyrostat.identification import accept
    from gyrostat.identification import validate as predict
    from gyrostat.reports.page import validation_page
    from gyrostat.wheel import read_wheel_sheet

    if out is not None:
        names = ("validation.html", "validation.json")
        check_outputs(Path(out), names, by="validate", force=force)
    one_of(current_hold, HOLDS, "--current-hold")
    if isinstance(sheet, str | Path):
        sheet = read_wheel_sheet(sheet, partial=True)
    # accept a wheel marked as impossible: validation is the test of it
    wheel_data = wheel_model(model, force=True)
    wheel_data.wheel()
    values = {**wheel_data.values, **_drive(hold, wheel_data.static_friction())}
    measured = load_records(
        record,
        say,
        columns=columns,
        units=units,
        unsigned_current=unsigned_current,
        unsigned_speed=unsigned_speed,
        missing=missing,
    )[0]
    result = predict(
        wheel_data.static_friction(),
        values,
        measured,
        current_hold=current_hold,  # pyright: ignore[reportArgumentType]
        covariance=wheel_data.covariance(),
    )
    if sheet is not None:
        result = replace(result, acceptance=accept(sheet, wheel_data, result))
    if out is not None:
        text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        page = validation_page(result, command=command)
        with new_files(Path(out), by="validate", force=force) as folder:
            (folder / "validation.html").write_text(page, encoding="utf-8")
            (folder / "validation.json").write_text(text + "\n", encoding="utf-8")
    for line in lines(result):
        say(line)
    return result


def bench(
    model: "WheelModel | Wheel | Fit | str | Path",
    out: "str | Path | None" = None,
    *,
    profile: str = "steps",
    duration: Quantity = 300.0,
    rate: float = 10.0,
    low: Quantity | None = None,
    high: Quantity | None = None,
    period: Quantity | None = None,
    initial_speed: Quantity = 0.0,
    speed_sigma: Quantity = 0.0,
    speed_quantum: Quantity = 0.0,
    jitter: float = 0.0,
    dropouts: float = 0.0,
    seed: int = 0,
    design: str | Iterable[str] | None = None,
    target_sigma: Quantity | Iterable[Quantity] | None = None,
    max_speed: Quantity | None = None,
    slew: float | None = None,
    ripple: float | None = None,
    drift: Named = None,
    tests: str | Iterable[str] | None = None,
    verdict: "str | Path | None" = None,
    simulate: int = 0,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.bench",
) -> "Record | Design | TestPlan | BenchVerdict":
    """Simulate the record of a known wheel, design the next one, or plan and judge bench tests.

    Args:
        model: Wheel, its model, an identification, or path of model.toml; with `design` also of
            fit.json; with `tests` or `verdict` path of a spec sheet.
        out: File for the record, .csv or .parquet; None writes no file. With `design`, a .csv with
            the current and the speed of the estimated wheel, and NAME.json and NAME.html beside it.
        profile: "steps", "sines" or "ramps".
        duration: Duration of the record, s; with `design` the longest one.
        rate: Samples per second, Hz.
        low: Smallest current amplitude, A.
        high: Largest current amplitude, A; with `design` the limit of the current, by default four
            times the breakaway current.
        period: Period of one step, cycle or ramp, s.
        initial_speed: Wheel speed at the first sample, rad/s.
        speed_sigma: Standard deviation of the tachometer noise, rad/s; with `design`, zero means
            that of the fit.
        speed_quantum: Quantisation step of the tachometer, rad/s.
        jitter: Jitter of the sample times, fraction of the interval.
        dropouts: Fraction of missing speeds.
        seed: Seed of currents and noise; with `design` of the search.
        design: Parameters or linear combinations, such as "static-coulomb", that the next record
            is to determine best (c-optimal for one, D-optimal for several).
        target_sigma: Standard deviation wanted of each of them, SI or with a unit; the record then
            ends as soon as nine of ten wheels that agree with the fit reach it.
        max_speed: Largest speed that a designed record may reach, rad/s.
        slew: Largest rate of change of the current of a designed record, A/s.
        ripple: Torque ripple, rms over the dry friction torque; by default that of the fit.
        drift: Drift of friction that a designed record has, viscous=SHARE,dry=SHARE from mid-record
            to its end, one sigma; by default that of the fit.
        tests: Names of bench tests, or "all": plan them from the spec sheet, `out` is a folder for
            profiles, templates of records, plan.json and plan.html; with `verdict` the tests to
            judge.
        verdict: Folder with the records of bench tests: judge them against the limits of the spec
            sheet, `out` is a folder for acceptance.html, acceptance.pdf and acceptance.json.
        simulate: Number of simulated records of each bench test or design, which check the
            predicted sigma.
        force: Whether to replace a file that gyrostat did not write, and to accept a wheel that its
            identification marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the page of a design names as its origin.

    Raises:
        InputError: A wheel or option cannot be used, or an existing file would be replaced.
    """
    path = None if out is None else Path(out)
    usual = {"profile": "steps", "duration": "300", "rate": "10"}
    record_options = {
        "profile": profile,
        "duration": duration,
        "rate": rate,
        "low": low,
        "high": high,
        "period": period,
        "initial_speed": initial_speed,
        "speed_sigma": speed_sigma,
        "speed_quantum": speed_quantum,
        "jitter": jitter,
        "dropouts": dropouts,
        "design": design,
        "target_sigma": target_sigma,
        "max_speed": max_speed,
        "slew": slew,
        "ripple": ripple,
        "drift": drift,
    }
    if tests is not None or verdict is not None:
        where = "--tests" if verdict is None else "--verdict"
        refuse_given(changed_options(record_options, usual), where, "a record")
        options: dict[str, Any] = {"force": force, "say": say, "command": command}
        if verdict is None:
            return plan_bench(model, tests or "all", path, simulate=simulate, seed=seed, **options)
        refuse_given({"--simulate": simulate or None}, "--verdict", "--tests or --design")
        return judge_bench(model, verdict, tests, path, **options)
    if design is not None:
        simulated_only = ("profile", "low", "period", "speed_quantum", "jitter", "dropouts")
        own = {name: record_options[name] for name in simulated_only}
        refuse_given(changed_options(own, usual), "--design", "a simulated record")
        return design_bench(
            model,
            design,
            path,
            duration=duration,
            rate=rate,
            most=high,
            slew=slew,
            max_speed=max_speed,
            initial_speed=initial_speed,
            speed_sigma=speed_sigma,
            target_sigma=target_sigma,
            ripple=ripple,
            drift=drift,
            simulate=simulate,
            seed=seed,
            force=force,
            say=say,
            command=command,
        )
    designs_only = ("target_sigma", "max_speed", "slew", "ripple", "drift")
    own = {name: record_options[name] for name in designs_only} | {"simulate": simulate}
    refuse_given(changed_options(own, usual), "a simulated record", "--design")
    return bench_record_file(
        model,
        path,
        profile,
        duration=duration,
        telemetry={
            "rate": rate,
            "speed_sigma": speed_sigma,
            "speed_quantum": speed_quantum,
            "jitter": jitter,
            "dropouts": dropouts,
        },
        amplitudes=(low, high),
        initial_speed=initial_speed,
        period=period,
        seed=seed,
        force=force,
        say=say,
    )


def _drive(hold: Named, model: "type[Friction]") -> dict[str, float]:
    """Current offset of the drive, A, which is not part of a model file."""
    parameters = parameters_in_si(named(hold, "--hold", bare=True), model, "--hold")
    for name, value in parameters.items():
        if name != "current_bias":
            raise InputError(
                f"--hold: found {name}, expected current_bias: the model file holds the wheel"
            )
        if value is None:
            raise InputError("--hold current_bias: found no value, expected one in A")
    return parameters
