"""Error messages of the record readers."""

from collections.abc import Iterable
from pathlib import Path

from gyrostat.core.errors import InputError, reason_of

_LONGEST = 60  # characters of a file's text shown in a message
_MOST = 30  # names listed in a message


def shown(text: str) -> str:
    """Quote a text from a file, on one line and shortened."""
    return repr(text if len(text) <= _LONGEST else text[:_LONGEST] + "...")


def listed(names: Iterable[str]) -> str:
    """List names from a file on one line, shortened."""
    quoted = [shown(name) for name in names]
    suffix = f" and {len(quoted) - _MOST} more" if len(quoted) > _MOST else ""
    return ", ".join(quoted[:_MOST]) + suffix


def counted(count: int, noun: str = "sample") -> str:
    """Count with its noun: '1 sample', '2 samples'."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def place(file: Path, row: int | None = None, column: str | None = None) -> str:
    """Place for a message: 'FILE: row R, column C', without the parts that are None."""
    # A file name may contain line breaks and bytes that are not text.
    name = str(file) if str(file).isprintable() else repr(str(file))
    parts = [f"row {row}"] if row is not None else []
    if column is not None:
        parts.append(f"column {shown(column)}")
    return f"{name}: {', '.join(parts)}" if parts else name


def fault(
    file: Path, found: str, expected: str, row: int | None = None, column: str | None = None
) -> InputError:
    """Error 'FILE: row R, column C: found X, expected Y'. In a text file the row is the line."""
    return InputError(f"{place(file, row, column)}: found {found}, expected {expected}")


def too_many(file: Path, max_samples: int, row: int | None = None) -> InputError:
    """Error for a file with more samples than accepted."""
    expected = "no more: split the file, or raise max_samples"
    return fault(file, f"more than {counted(max_samples)}", expected, row)


def damaged(file: Path, wanted: str, error: Exception) -> InputError:
    """Error for a file whose content does not match its suffix."""
    return fault(file, f"damaged or other content ({shown(reason_of(error))})", wanted)
