"""Arguments of the verbs on several fits: files, dates, labels."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.core.errors import InputError

if TYPE_CHECKING:
    from datetime import datetime

    from gyrostat.identification import Fit, StoredFit


def fit_files(fits: "Sequence[Fit | str | Path] | str | Path") -> "list[Fit | Path]":
    """List fits, or paths of their fit.json.

    Args:
        fits: Fits; paths of fit.json; or folders with one, or with folders that have one.

    Raises:
        InputError: A folder has no fit.
    """
    items: list[Fit | Path] = []
    for fit in [fits] if isinstance(fits, str | Path) else fits:
        path = Path(fit) if isinstance(fit, str | Path) else None
        if path is None or not path.is_dir():
            items.append(fit if path is None else path)  # pyright: ignore[reportArgumentType]
        elif (path / "fit.json").exists():
            items.append(path / "fit.json")
        else:
            inner = sorted(path.glob("*/fit.json"))
            if not inner:
                raise InputError(f"{path}: found no */fit.json, expected folders of identify")
            items += inner
    return items


def date_of(text: str, option: str) -> "datetime":
    """Parse the date of an option; raises `InputError`."""
    from gyrostat.identification.result.stored_fit import parse_date

    date = parse_date(text)
    if date is None:
        raise InputError(f"{option}: found {text!r}, expected a date such as 2026-03-01")
    return date


def dates_of(dates: str | Iterable[str], count: int) -> "list[datetime]":
    """Parse the dates of several fits.

    Args:
        dates: Date of each; text separated by commas.
        count: Number of fits.

    Raises:
        InputError: The number of dates differs, or one is not a date.
    """
    texts = [d.strip() for d in dates.split(",")] if isinstance(dates, str) else list(dates)
    if len(texts) != count:
        raise InputError(f"--dates: found {len(texts)}, expected one for each of {count} fits")
    return [date_of(text, "--dates") for text in texts]


def labels_of(fits: "list[StoredFit]", *, same_wheel: bool) -> list[str]:
    """Short label of each fit: its date or serial number, its file if these are not unique.

    Args:
        fits: Fits.
        same_wheel: Whether they are of one wheel; the label is then the date.
    """
    for label in (
        lambda fit: fit.date.date().isoformat() if same_wheel and fit.date else "",
        lambda fit: "" if same_wheel else fit.serial,
        lambda fit: Path(fit.name).parent.name,
    ):
        labels = [label(fit) for fit in fits]
        if all(labels) and len(set(labels)) == len(fits):
            return labels
    return [f"{k + 1}: {fit.name}" for k, fit in enumerate(fits)]
