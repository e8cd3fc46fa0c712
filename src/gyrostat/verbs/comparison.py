"""Verb `compare`: compare fits of one wheel over dates, or of the wheels of a batch."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, one_of, silent

if TYPE_CHECKING:
    from gyrostat.identification import Comparison, Fit, StoredFit

WHEELS = ("same", "different")


def compare(
    fits: "Sequence[Fit | str | Path]",
    out: "str | Path | None" = None,
    *,
    wheels: str | None = None,
    same_bench: bool = False,
    dates: str | Iterable[str] | None = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.compare",
) -> "Comparison":
    """Compare fits of one wheel over dates, or of the wheels of a batch.

    Args:
        fits: At least two identifications, or paths of fit.json or of folders with one.
        out: Folder for comparison.json and comparison.html; None writes no file.
        wheels: "same": one wheel, with one inertia; "different": a batch. By default, the serial
            numbers of the records decide.
        same_bench: Whether all records are from one bench, so that the errors of current scale,
            speed scale and clock are common.
        dates: Date of each fit, in place of those of the records; text separated by commas.
        force: Whether to replace files that gyrostat did not write, and to accept wheels that their
            identification marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Differences with their standard deviations, trends or spreads, and what is significant.

    Raises:
        InputError: A fit cannot be used, the serial numbers do not decide, or existing files would
            be replaced.
    """
    import json

    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.identification import compare_fits, stored_fit
    from gyrostat.identification.judge.comparison_text import comparison_table
    from gyrostat.reports.comparison import comparison_page

    if out is not None:
        names = ("comparison.html", "comparison.json")
        check_outputs(Path(out), names, by="compare", force=force)
    if wheels is not None:
        one_of(wheels, WHEELS, "--wheels")
    stored_fits = [stored_fit(_file(fit), force=force) for fit in fits]
    if dates is not None:
        stored_fits = _with_dates(stored_fits, dates)
    same_wheel = _same_wheel(stored_fits) if wheels is None else wheels == "same"
    result = compare_fits(
        stored_fits, _labels(stored_fits, same_wheel), same_wheel=same_wheel, same_bench=same_bench
    )
    if out is not None:
        text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        page = comparison_page(result, command=command)
        with new_files(Path(out), by="compare", force=force) as folder:
            (folder / "comparison.html").write_text(page, encoding="utf-8")
            (folder / "comparison.json").write_text(text + "\n", encoding="utf-8")
    for line in comparison_table(result):
        say(line)
    return result


def _file(fit: "Fit | str | Path") -> "Fit | Path":
    """Fit, or path of its fit.json."""
    if not isinstance(fit, str | Path):
        return fit
    path = Path(fit)
    return path / "fit.json" if path.is_dir() else path


def _with_dates(fits: "list[StoredFit]", dates: str | Iterable[str]) -> "list[StoredFit]":
    """Fits with the dates that the user gives."""
    from dataclasses import replace

    from gyrostat.identification.result.stored_fit import parse_date

    texts = [d.strip() for d in dates.split(",")] if isinstance(dates, str) else list(dates)
    if len(texts) != len(fits):
        raise InputError(f"--dates: found {len(texts)}, expected one for each of {len(fits)} fits")
    results = []
    for fit, text in zip(fits, texts, strict=True):
        date = parse_date(text)
        if date is None:
            raise InputError(f"--dates: found {text!r}, expected a date such as 2026-03-01")
        results.append(replace(fit, date=date))
    return results


def _same_wheel(fits: "list[StoredFit]") -> bool:
    """Whether the serial numbers say that all fits are of one wheel."""
    serials = [fit.serial for fit in fits]
    if all(serials):
        distinct = len(set(serials))
        if distinct in (1, len(fits)):
            return distinct == 1
        raise InputError(
            f"compare: found serial numbers {', '.join(serials)}, expected one wheel or one fit of "
            "each wheel: compare the fits of one wheel first, or give --wheels"
        )
    name = next(fit.name for fit in fits if not fit.serial)
    raise InputError(
        f"{name}: found no serial number, expected one in its records (comment '# serial: RW-07'), "
        "or --wheels same or different"
    )


def _labels(fits: "list[StoredFit]", same_wheel: bool) -> list[str]:
    """Short label of each fit: its date or serial number, its file if these are not unique."""
    for label in (
        lambda fit: fit.date.date().isoformat() if same_wheel and fit.date else "",
        lambda fit: "" if same_wheel else fit.serial,
        lambda fit: Path(fit.name).parent.name,
    ):
        labels = [label(fit) for fit in fits]
        if all(labels) and len(set(labels)) == len(fits):
            return labels
    return [f"{k + 1}: {fit.name}" for k, fit in enumerate(fits)]
