"""Tests that a bench runs, modes of the verb `bench`: their plan, and the verdict on them."""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, parts_of

if TYPE_CHECKING:
    from gyrostat.identification.bench_tests.bench_sheet import BenchSheet
    from gyrostat.identification.bench_tests.bench_test import PlannedRecord
    from gyrostat.identification.bench_tests.plan import TestPlan
    from gyrostat.identification.bench_tests.verdict import BenchVerdict, RecordFile

REPORT = ("acceptance.html", "acceptance.json", "acceptance.pdf")
SPELLING = "spec sheet .toml with tables of quantities and [bench]"


def changed_options(
    options: Mapping[str, object], usual: Mapping[str, str]
) -> dict[str, object | None]:
    """Option -> value, None where it is the default.

    Args:
        options: Argument -> value.
        usual: Argument -> default as text; of the others it is none, or zero.
    """
    changed = {}
    for name, value in options.items():
        text = str(value).removesuffix(".0")
        same = value is None or text == usual.get(name, "0")
        changed["--" + name.replace("_", "-")] = None if same else value
    return changed


def _sheet(model: object) -> "BenchSheet":
    """Spec sheet that the user names.

    Raises:
        InputError: It is not a path of one.
    """
    from gyrostat.identification.bench_tests.bench_sheet import read_bench_sheet

    if not isinstance(model, str | Path) or Path(model).suffix.lower() != ".toml":
        raise InputError(f"{model}: found no TOML file, expected a {SPELLING}")
    return read_bench_sheet(Path(model))


def _names(tests: str | Iterable[str]) -> list[str]:
    """Names of tests, with commas between or in a list."""
    parts = [tests] if isinstance(tests, str) else tests
    return [str(name).strip() for part in parts for name in parts_of(part) if str(name).strip()]


def plan_bench(
    model: object,
    tests: str | Iterable[str],
    out: Path | None,
    *,
    simulate: int,
    seed: int,
    force: bool,
    say: Say,
    command: str,
) -> "TestPlan":
    """Plan tests; write profiles, templates of records, and the plan as JSON and page.

    Args:
        model: Path of a spec sheet.
        tests: Names of tests, or "all".
        out: Folder; None writes no file.
        simulate: Number of simulated tests of each kind.
        seed: Seed of the simulation.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message.
        command: Text that the page names as its origin.

    Raises:
        InputError: The sheet or a name cannot be used, or an existing file would be replaced.
    """
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.core.views import lines
    from gyrostat.identification.bench_tests.plan import plan_tests
    from gyrostat.identification.bench_tests.plan_text import content
    from gyrostat.identification.bench_tests.verdict import record_names
    from gyrostat.reports.bench_tests import plan_page

    sheet, names = _sheet(model), _names(tests)
    if out is not None:
        records = [name for each in record_names(sheet, names).values() for name in each]
        folders = [f"{folder}/{n}.csv" for folder in ("profiles", "records") for n in records]
        check_outputs(out, ["plan.html", "plan.json", *folders], by="bench", force=force)
    plan = plan_tests(sheet, names, runs=simulate, seed=seed, say=say)
    if out is not None:
        text = json.dumps(content(plan), indent=1, ensure_ascii=False, allow_nan=False)
        page = plan_page(plan, command=command)
        with new_files(out, by="bench", force=force) as folder:
            for name in ("profiles", "records"):
                (folder / name).mkdir()
            for planned in plan.tests:
                for record in planned.records:
                    _write_profile(record, folder)
            (folder / "plan.json").write_text(text + "\n", encoding="utf-8")
            (folder / "plan.html").write_text(page, encoding="utf-8")
    for line in lines(plan):
        say(line)
    if out is not None:
        say(f"written: {out / 'plan.html'}, profiles and templates of records in {out}")
    return plan


def _write_profile(record: "PlannedRecord", folder: Path) -> None:
    """Write the current of a record, and the template that the bench fills."""
    rows = zip(record.time.tolist(), record.current.tolist(), strict=True)
    with (folder / "profiles" / f"{record.name}.csv").open("w", encoding="utf-8") as stream:
        stream.write("time_s,current_A\n")
        stream.writelines(f"{time:.10g},{current:.6g}\n" for time, current in rows)
    comments = ["serial:", "date:", "operator:", "temperature:"]
    header = "".join(f"# {text}\n" for text in comments)
    template = header + ",".join(record.columns) + "\n"
    (folder / "records" / f"{record.name}.csv").write_text(template, encoding="utf-8")


def judge_bench(
    model: object,
    records: str | Path,
    tests: str | Iterable[str] | None,
    out: Path | None,
    *,
    force: bool,
    say: Say,
    command: str,
) -> "BenchVerdict":
    """Judge the records of tests; write the acceptance report as HTML, PDF and JSON.

    Args:
        model: Path of the spec sheet of the plan.
        records: Folder with the records, named as their templates.
        tests: Names of tests; None for all.
        out: Folder; None writes no file.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message.
        command: Text that the report names as its origin.

    Raises:
        InputError: The sheet or a record cannot be used, no record is there, or an existing file
            would be replaced.
    """
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.core.views import lines
    from gyrostat.identification.bench_tests.verdict import judge_tests, record_names
    from gyrostat.identification.bench_tests.verdict_text import content
    from gyrostat.reports.bench_tests import report_page, report_pdf

    if out is not None:
        check_outputs(out, REPORT, by="bench", force=force)
    sheet, names = _sheet(model), _names(tests or "all")
    folder = Path(records)
    if not folder.is_dir():
        raise InputError(f"{folder}: found no folder, expected one with the records of the tests")
    wanted = [name for each in record_names(sheet, names).values() for name in each]
    files = _read_records(folder, wanted)
    if not files:
        raise InputError(f"{folder}: found no filled record, expected one such as {wanted[0]}.csv")
    verdict = judge_tests(sheet, names, files)
    if out is not None:
        text = json.dumps(content(verdict), indent=1, ensure_ascii=False, allow_nan=False)
        page = report_page(verdict, command=command)
        document = report_pdf(verdict, command=command)
        with new_files(out, by="bench", force=force) as scratch:
            (scratch / "acceptance.html").write_text(page, encoding="utf-8")
            (scratch / "acceptance.json").write_text(text + "\n", encoding="utf-8")
            (scratch / "acceptance.pdf").write_bytes(document)
    for line in lines(verdict):
        say(line)
    if out is not None:
        say(f"written: {', '.join(str(out / name) for name in REPORT)}")
    return verdict


def _read_records(folder: Path, names: Iterable[str]) -> "dict[str, RecordFile]":
    """Records of a folder by name; templates without rows are left out."""
    from gyrostat.core.files import digest_of
    from gyrostat.identification.bench_tests.verdict import RecordFile
    from gyrostat.telemetry import read_record

    files = {}
    for name in names:
        paths = [p for p in sorted(folder.glob(f"{name}.*")) if p.is_file()]
        if len(paths) > 1:
            found = ", ".join(path.name for path in paths)
            raise InputError(f"{folder}: found {found}, expected one file of the record {name}")
        for path in paths:
            if not _is_template(path):
                record = read_record(path)
                files[name] = RecordFile(record, path.name, digest_of(path) or "")
    return files


def _is_template(path: Path) -> bool:
    """Whether a text file has no rows below its header."""
    if path.suffix.lower() != ".csv":
        return False
    with path.open("rb") as stream:
        rows = [line for line in (stream.readline() for _ in range(20)) if line.strip()]
    return len([line for line in rows if not line.lstrip().startswith(b"#")]) < 2
