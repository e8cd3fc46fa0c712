"""MDF files of ASAM (MF4), read by asammdf."""

import gc
import logging
import sys
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import Channel, logged_damage, read_channels
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "an MDF file"


class Mdf(RecordFormat):
    """Channels of all groups, with their physical values. Each group has its own times.

    A group is named by its acquisition, or 'group N' from 0 if it has no such name.
    """

    suffixes: ClassVar[tuple[str, ...]] = (".mf4", ".mdf")

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        try:
            from asammdf import MDF  # pyright: ignore[reportMissingImports]
        except ImportError:
            raise missing(str(file), "asammdf", "bench") from None
        hook = sys.unraisablehook
        sys.unraisablehook = lambda _: None
        try:
            with (
                logged_damage("asammdf", lambda record: record.levelno >= logging.ERROR),
                file.open("rb") as stream,
                MDF(stream) as source,
            ):
                return read_channels(file, _channels(source), request, _WANTED)
        except InputError:
            raise
        except Exception as error:  # asammdf raises errors of many classes on damaged files
            reason = ValueError(str(error) or type(error).__name__)
        finally:
            # A file that could not be opened leaves an object whose destructor fails. It is young:
            # a search of all objects would take seconds in a process that has many.
            gc.collect(1)
            sys.unraisablehook = hook
        raise damaged(file, _WANTED, reason)


def _channels(source: Any) -> list[Channel]:
    channels = []
    names: set[str] = set()
    for index, group in enumerate(source.groups):
        name = str(getattr(group.channel_group, "acq_name", "") or "")
        if not name or name in names:
            name = f"group {index}"
        names.add(name)
        count = int(group.channel_group.cycles_nr)
        for position, channel in enumerate(group.channels):
            channels.append(
                Channel(
                    name=f"{name}/{channel.name}",
                    count=count,
                    read=partial(_values, source, index, position),
                    unit=_unit(channel),
                    base=index,
                )
            )
    return channels


def _values(source: Any, group: int, position: int) -> Any:
    """Physical values of a channel, (N,), masked where the file says that they are invalid."""
    signal = source.get(group=group, index=position, ignore_invalidation_bits=True)
    if signal.invalidation_bits is None:
        return signal.samples
    return np.ma.masked_where(np.asarray(signal.invalidation_bits, bool), signal.samples)


def _unit(channel: Any) -> str:
    """Unit of a channel: its own, or that of its conversion, where files of version 3 have it."""
    return channel.unit or str(getattr(channel.conversion, "unit", "") or "")
