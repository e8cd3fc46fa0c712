"""Verb `compare`: compare fits of one wheel over dates, or of the wheels of a batch."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say, one_of, silent
from gyrostat.verbs.stored_fits import dates_of, labels_of

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
        fits: At least two identifications, or paths of fit.json or of folders with one; or of
            model.toml, such as that of a wheel in flight by `monitor`.
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
        pairs = zip(stored_fits, dates_of(dates, len(stored_fits)), strict=True)
        stored_fits = [replace(fit, date=date) for fit, date in pairs]
    same_wheel = _same_wheel(stored_fits) if wheels is None else wheels == "same"
    result = compare_fits(
        stored_fits,
        labels_of(stored_fits, same_wheel=same_wheel),
        same_wheel=same_wheel,
        same_bench=same_bench,
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
    """Fit, or path of its fit.json or model.toml."""
    if not isinstance(fit, str | Path):
        return fit
    path = Path(fit)
    if not path.is_dir():
        return path
    files = [path / "fit.json", path / "model.toml"]
    return next((file for file in files if file.exists()), files[0])


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
