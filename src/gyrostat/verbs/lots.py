"""Verb `lot`: the distribution of the parameters of a lot of wheels."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Quantity, Say, in_si, one_of, silent
from gyrostat.verbs.stored_fits import fit_files

if TYPE_CHECKING:
    from gyrostat.identification import Fit, Lot, StoredFit

FILES = ("lot.html", "lot.json", "lot.toml")


def lot(
    fits: "Sequence[Fit | str | Path] | str | Path",
    out: "str | Path | None" = None,
    *,
    shape: str = "unknown",
    content: Quantity = 0.95,
    confidence: Quantity = 0.95,
    best: str = "lowest",
    set_size: int = 4,
    manifest: "str | Path | None" = None,
    same_bench: bool = False,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.lot",
) -> "Lot":
    """Estimate how the parameters of a lot of wheels are distributed, without errors of the fits.

    Args:
        fits: Identifications of at least 20 wheels, one of each; paths of fit.json; or folders with
            one, or with folders that have one.
        out: Folder for lot.json, lot.toml (a dispersion table for scenarios) and lot.html; None
            writes no file.
        shape: What is known of the distribution: "unknown", "normal" or "log-normal".
        content: Share of the wheels that the tolerance limits contain.
        confidence: Probability that they do.
        best: Criterion of the best set: "lowest", "highest" or "matched", and a parameter, such as
            "matched motor_constant"; by default the Coulomb torque or the first parameter.
        set_size: Number of wheels of the best set.
        manifest: CSV file with columns serial and date, in place of the dates of the records.
        same_bench: Whether all records are from one bench, so that the errors of current scale,
            speed scale and clock are common.
        force: Whether to replace files that gyrostat did not write, and to accept wheels that their
            identification marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Distributions, tolerance limits, outliers, correlations, drifts and the best set.

    Raises:
        InputError: The fits are not of one lot, an argument cannot be used, or existing files would
            be replaced.
    """
    import json

    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.core.views import lines
    from gyrostat.identification import analyse_lot, dispersion_table, stored_fit
    from gyrostat.identification.lot.posterior import SHAPES
    from gyrostat.reports.lot import lot_page

    if out is not None:
        check_outputs(Path(out), FILES, by="lot", force=force)
    one_of(shape, SHAPES, "--shape")
    shares = [_share(content, "--content"), _share(confidence, "--confidence")]
    criterion = _criterion(best)
    stored_fits = [stored_fit(fit, force=force) for fit in fit_files(fits)]
    labels = [fit.serial or Path(fit.name).parent.name or fit.name for fit in stored_fits]
    if not 2 <= set_size < max(len(labels), 3):
        raise InputError(
            f"--set-size: found {set_size}, expected 2 or more, and fewer than the {len(labels)} "
            "wheels"
        )
    if manifest is not None:
        stored_fits = _with_dates(stored_fits, labels, Path(manifest))
    result = analyse_lot(
        stored_fits,
        labels,
        shape=shape,
        content=shares[0],
        confidence=shares[1],
        best=criterion,
        set_size=set_size,
        same_bench=same_bench,
    )
    if out is not None:
        text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
        page = lot_page(result, command=command)
        with new_files(Path(out), by="lot", force=force) as folder:
            (folder / "lot.html").write_text(page, encoding="utf-8")
            (folder / "lot.json").write_text(text + "\n", encoding="utf-8")
            (folder / "lot.toml").write_text(dispersion_table(result), encoding="utf-8")
    for line in lines(result):
        say(line)
    return result


def _share(value: Quantity, where: str) -> float:
    """Share between 0.5 and 1, as a number or in per cent."""
    percent = isinstance(value, str) and value.strip().endswith("%")
    text = value.strip().removesuffix("%") if isinstance(value, str) else value
    share = in_si(text, "1", where) / (100.0 if percent else 1.0)
    if not 0.5 <= share <= 0.9999:
        raise InputError(f"{where}: found {value}, expected 0.5 to 0.9999, or 50 to 99.99 %")
    return share


def _criterion(text: str) -> tuple[str, str]:
    """Rule and parameter of the best set; an empty parameter if there is none."""
    from gyrostat.identification.lot.best_set import RULES

    rule, _, parameter = text.strip().partition(" ")
    if rule not in RULES:
        raise InputError(f"--best: found {text!r}, expected one of {', '.join(RULES)} first")
    return rule, parameter.strip()


def _with_dates(
    fits: "Sequence[StoredFit]", labels: Sequence[str], manifest: Path
) -> "list[StoredFit]":
    """Fits with the dates of production that a manifest has."""
    import csv
    from dataclasses import replace

    from gyrostat.core.toml_file import read_text
    from gyrostat.identification.result.stored_fit import parse_date

    rows = csv.DictReader(read_text(manifest, "a CSV file").splitlines(), skipinitialspace=True)
    columns = [name.strip() for name in rows.fieldnames or ()]
    if not {"serial", "date"} <= set(columns):
        raise InputError(
            f"{manifest}: found columns {', '.join(columns) or 'none'}, expected serial and date"
        )
    rows.fieldnames = columns
    dates = {}
    for row in rows:
        serial, text = ((row[name] or "").strip() for name in ("serial", "date"))
        date = parse_date(text)
        if date is None or serial in dates:
            found = f"{serial} twice" if serial in dates else f"date {text!r}"
            raise InputError(
                f"{manifest}: row {rows.line_num}: found {found}, expected each serial number "
                "once, with a date such as 2026-03-01"
            )
        dates[serial] = date
    for label in labels:
        if label not in dates:
            raise InputError(f"{manifest}: found no row of {label}, expected one of each wheel")
    return [replace(fit, date=dates[label]) for fit, label in zip(fits, labels, strict=True)]
