"""Columns of files that consist of named channels, in groups."""

import logging
from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.columns import MOTION, Column, Header
from gyrostat.telemetry.fault import counted, damaged, fault, shown, too_many
from gyrostat.telemetry.record_format import Request


@dataclass(frozen=True)
class Channel:
    """Channel of a file.

    Attributes:
        name: Name with that of its groups, 'GROUP/CHANNEL'.
        count: Number of values.
        read: Returns the values, (count,); masked where the file says that there is none.
        unit: Unit, as the file states it; empty if it does not.
        base: What the samples of the channel share with others that were taken at the same times;
            None if the file does not say.
        content: What the channel contains, if not real numbers.
    """

    name: str
    count: int
    read: Callable[[], NDArray]
    unit: str = ""
    base: Hashable = None
    content: str = ""


def read_channels(
    file: Path, channels: Sequence[Channel], request: Request, wanted: str
) -> Measured:
    """Read the chosen channels of a file.

    A channel can be chosen by its name with or without that of its group.

    Args:
        file: The file.
        channels: All channels of the file.
        request: What to read.
        wanted: The kind of file, for messages.

    Returns:
        The chosen channels; a masked value is an empty cell.

    Raises:
        InputError: A channel is missing, does not contain real numbers, has another number of
            values or another time base than the first one, or is damaged.
    """
    if not channels:
        raise fault(file, "no channels", f"{wanted} with time, current and speed")
    columns = (
        Column(
            index,
            tuple(dict.fromkeys((each.name, each.name.rpartition("/")[2]))),
            each.unit,
            each.base,
        )
        for index, each in enumerate(channels)
    )
    chosen = request.choose(Header(file, tuple(columns)))
    picked = {role: channels[column.index] for role, column in chosen.items()}
    first = picked.get("time") or next(iter(picked.values()))
    for role, channel in picked.items():
        if channel.content:
            raise fault(file, channel.content, "a vector of real numbers", column=channel.name)
        if channel.base != first.base and None not in (channel.base, first.base):
            apart = ", or the speed in speed_from, also of this file" if role in MOTION else ""
            expected = f"that of {shown(first.name)}{apart}"
            raise fault(file, "another time base", expected, column=channel.name)
        if channel.count > request.max_samples:
            raise too_many(file, request.max_samples)
    read = {role: _numbers(file, channel, wanted) for role, channel in picked.items()}
    values = {role: np.ma.filled(each, np.nan) for role, each in read.items()}
    for role, channel in picked.items():
        if values[role].size != first.count:
            expected = f"{first.count} as in {shown(first.name)}"
            found = counted(values[role].size, "value")
            raise fault(file, found, expected, column=channel.name)
    empty = {role: np.ma.getmaskarray(each) for role, each in read.items()}
    return Measured(file, chosen, values, empty, np.arange(1, first.count + 1))


def _numbers(file: Path, channel: Channel, wanted: str) -> NDArray[np.float64]:
    """Values of a channel, (N,), which may be masked."""
    try:
        values = np.asanyarray(channel.read())
    except (InputError, OSError):
        raise
    except Exception as error:  # a damaged file makes the libraries raise errors of many classes
        raise damaged(file, wanted, error) from None
    if content := content_of(values.dtype):
        raise fault(file, content, "a vector of real numbers", column=channel.name)
    return values.astype(np.float64)


@contextmanager
def logged_damage(package: str, damage: Callable[[logging.LogRecord], bool]) -> Iterator[None]:
    """Raise an error where a package only logs damage; its other messages are dropped.

    Args:
        package: Name of the package.
        damage: Whether a message says that the file is damaged.

    Raises:
        ValueError: Within the context, at such a message.
    """

    def check(record: logging.LogRecord) -> bool:
        if damage(record):
            raise ValueError(record.getMessage())
        return False

    names = [name for name in logging.root.manager.loggerDict if name.startswith(package)]
    loggers = [logging.getLogger(name) for name in names]
    for each in loggers:
        each.addFilter(check)
    try:
        yield
    finally:
        for each in loggers:
            each.removeFilter(check)


def is_time(name: str) -> bool:
    """Whether a channel without the name of its group is one of times."""
    last = name.rpartition("/")[2].casefold()
    return last == "t" or last.startswith(("t_", "time")) or last.endswith(("time", "timestamp"))


def content_of(dtype: np.dtype) -> str:
    """What values of a type are, if not real numbers; otherwise empty."""
    return "" if dtype.kind in "iufb" else f"values of type {dtype}"


def seconds(times: NDArray[np.datetime64]) -> NDArray[np.float64]:
    """Time since the first of some dates, (N,), s."""
    return (times - times[:1]) / np.timedelta64(1, "ns") * 1e-9
