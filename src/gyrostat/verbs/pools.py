"""Verb `pool`: one model of a wheel from records at several dates and temperatures."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, Say, in_si, parts_of, silent
from gyrostat.verbs.stored_fits import date_of, dates_of, fit_files, labels_of

if TYPE_CHECKING:
    from gyrostat.identification import Fit, Pool, StoredFit
    from gyrostat.telemetry import Record
    from gyrostat.wheel.friction_laws import Law

FILES = ("pool.html", "pool.json", "model.toml")


def pool(
    records: "Sequence[Record | Fit | str | Path]",
    out: "str | Path | None" = None,
    *,
    temperature: Quantity | None = None,
    date: str | None = None,
    oil: str | None = None,
    serial: str | None = None,
    dates: str | Iterable[str] | None = None,
    temperatures: str | Iterable[Quantity] | None = None,
    same_bench: bool = False,
    inertia: Quantity | None = None,
    current_scale: Quantity | None = None,
    speed_scale: Quantity | None = None,
    clock: Quantity | None = None,
    ripple: float | None = None,
    model: "str | Law | None" = None,
    hold: Named = None,
    free: str | Iterable[str] | None = None,
    prior: Named = None,
    speed_sigma: Quantity | None = None,
    columns: Mapping[str, str] | str | Path | None = None,
    units: Mapping[str, str] | str | None = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.pool",
) -> "Pool":
    """Pool records of one wheel at several dates and temperatures into one model.

    Args:
        records: At least two records or paths of records, each of which is identified first; or
            identifications, paths of fit.json, or folders with one or with folders that have one.
        out: Folder for pool.json, model.toml and pool.html, and for the identifications of records
            (fits/NAME); None writes no file.
        temperature: Temperature of the prediction and of model.toml, °C; by default the mean of
            the records.
        date: Date of the prediction; by default that of the last record.
        oil: Oil of the bearings: two temperatures, °C, with kinematic viscosities, mm²/s,
            "40:108,100:14.6", or B and C of Vogel's equation, °C, "vogel:845,110".
        serial: Serial number of the wheel: others are left out.
        dates: Date of each record, in place of its own; text separated by commas.
        temperatures: Temperature of each record, °C, in place of its own.
        same_bench: Whether all records are from one bench, so that the errors of current scale,
            speed scale and clock are common.
        inertia: As for `identify`, as are all further options up to `units`; records alone use
            them.
        current_scale: True divided by measured current.
        speed_scale: True divided by measured speed.
        clock: True divided by recorded time.
        ripple: Torque ripple, rms over the dry friction torque.
        model: Friction model.
        hold: Parameters that are not estimated.
        free: Further parameters to estimate.
        prior: A-priori knowledge: name -> (mean, standard deviation).
        speed_sigma: Standard deviation of the measured speed, rad/s.
        columns: Role -> column, or a .toml file of them.
        units: Role -> unit, if the file has none.
        force: Whether to replace files that gyrostat did not write, and to accept wheels that their
            identification marked as impossible.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Prediction for a further record, scatter between records, law over temperature, trend, and
        the prediction of each record from the others.

    Raises:
        InputError: The records are not of one wheel, fewer than two are valid, an argument cannot
            be used, or existing files would be replaced.
    """
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.views import lines
    from gyrostat.identification import pool_fits
    from gyrostat.identification.pool.oil import parse_oil

    if out is not None:
        check_outputs(Path(out), FILES, by="pool", force=force)
    viscosity = None if oil is None else parse_oil(oil, "--oil")
    warm = None if temperature is None else in_si(temperature, "temperature", "--temperature")
    day = None if date is None else date_of(date, "--date")
    options = {
        "inertia": inertia,
        "current_scale": current_scale,
        "speed_scale": speed_scale,
        "clock": clock,
        "ripple": ripple,
        "model": model,
        "hold": hold,
        "free": free,
        "prior": prior,
        "speed_sigma": speed_sigma,
        "columns": columns,
        "units": units,
    }
    items = _items(records)
    changes = _changes(len(items), dates, temperatures)
    fits = _stored_fits(items, out, options, force=force, say=say)
    pairs = zip(fits, changes, strict=True)
    fits = [None if fit is None else replace(fit, **change) for fit, change in pairs]
    valid = [fit for fit in fits if fit is not None and serial in (None, fit.serial)]
    if serial is not None:
        say(f"{len(valid)} of {len(fits)} records are of the wheel {serial}")
    result = pool_fits(
        valid,
        labels_of(valid, same_wheel=True),
        temperature=warm,
        date=day,
        oil=viscosity,
        same_bench=same_bench,
    )
    if out is not None:
        _write(result, Path(out), command=command, force=force)
    for line in lines(result):
        say(line)
    return result


def _write(result: "Pool", out: Path, *, command: str, force: bool) -> None:
    """Write pool.html, pool.json and, for a friction model of this package, model.toml."""
    import json

    from gyrostat.core.outputs import new_files
    from gyrostat.identification.pool.pool_model import pooled_model
    from gyrostat.reports.pool import pool_page
    from gyrostat.wheel.model_file import write_model

    text = json.dumps(result.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    page, wheel = pool_page(result, command=command), pooled_model(result)
    with new_files(out, by="pool", force=force) as folder:
        (folder / "pool.html").write_text(page, encoding="utf-8")
        (folder / "pool.json").write_text(text + "\n", encoding="utf-8")
        if wheel is not None:
            write_model(folder / "model.toml", wheel)


def _items(records: "Sequence[Record | Fit | str | Path]") -> "list[Record | Fit | Path]":
    """Records and fits, with the fits of folders listed."""
    items: list[Any] = [*fit_files(records)]  # pyright: ignore[reportArgumentType]
    for item in items:
        if isinstance(item, Path) and not item.exists():
            raise InputError(f"{item}: found no file, expected a record, a fit.json or a folder")
    return items


def _stored_fits(
    items: "Sequence[Record | Fit | Path]",
    out: "str | Path | None",
    options: Mapping[str, Any],
    *,
    force: bool,
    say: Say,
) -> "list[StoredFit | None]":
    """Fit of each item; None for those without a valid fit, which are reported.

    Raises:
        InputError: No item has a valid fit, or an option of `identify` is given without a record.
    """
    from gyrostat.identification import Fit, stored_fit

    fits: list[StoredFit | None] = []
    faults: list[InputError] = []
    unused = [name for name, value in options.items() if value not in (None, {}, (), [])]
    for k, item in enumerate(items):
        try:
            if not isinstance(item, Fit) and not (
                isinstance(item, Path) and item.suffix == ".json"
            ):
                unused = []
                item = _identified(item, k, out, options, force=force, say=say)
            fits.append(stored_fit(item, force=force))
        except InputError as error:
            faults.append(error)
            fits.append(None)
    if faults and len(faults) == len(items):
        raise faults[0]
    if unused:
        raise InputError(
            f"--{unused[0].replace('_', '-')}: found identifications alone, which keep what they "
            "were made with, expected a record that needs it"
        )
    for fault in faults:
        say(f"left out: {fault}")
    return fits


def _identified(
    record: "Record | Path",
    place: int,
    out: "str | Path | None",
    options: Mapping[str, Any],
    *,
    force: bool,
    say: Say,
) -> "Fit":
    """Identification of one record, written to its own folder."""
    from gyrostat.verbs.identification import identify

    name = record.stem if isinstance(record, Path) else Path(record.name).stem
    say(f"identifying {name}")
    folder = None if out is None else Path(out) / "fits" / f"{place + 1:02}-{name}"
    return identify(record, folder, **options, force=force, command=f"gyrostat pool, record {name}")


def _changes(
    count: int,
    dates: str | Iterable[str] | None,
    temperatures: str | Iterable[Quantity] | None,
) -> list[dict[str, Any]]:
    """Date and temperature that the user gives for each item; checks the number of items.

    Raises:
        InputError: There are fewer than two items, or dates or temperatures do not suit them.
    """
    if count < 2:
        raise InputError(f"pool: records of one wheel: found {count}, expected at least 2")
    changes: list[dict[str, Any]] = [{} for _ in range(count)]
    days = [] if dates is None else dates_of(dates, count)
    warm = [] if temperatures is None else [*map(str, parts_of(temperatures))]
    if temperatures is not None and len(warm) != count:
        raise InputError(
            f"--temperatures: found {len(warm)}, expected one for each of {count} records"
        )
    for change, day in zip(changes, days, strict=False):
        change["date"] = day
    for change, value in zip(changes, warm, strict=False):
        change["temperature"] = in_si(value.strip(), "temperature", "--temperatures")
    return changes
