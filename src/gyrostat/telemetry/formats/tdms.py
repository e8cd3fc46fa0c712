"""TDMS files of LabVIEW, read by npTDMS."""

import logging
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.extras import missing
from gyrostat.telemetry.assemble import Measured
from gyrostat.telemetry.channels import (
    Channel,
    content_of,
    is_time,
    logged_damage,
    read_channels,
    seconds,
)
from gyrostat.telemetry.fault import damaged
from gyrostat.telemetry.record_format import RecordFormat, Request

_WANTED = "a TDMS file"


class Tdms(RecordFormat):
    """Channels of all groups; of waveforms without a time channel, also the time since the start.

    Units are those of the property `unit_string`.
    """

    suffixes: ClassVar[tuple[str, ...]] = (".tdms",)

    @staticmethod
    def read(file: Path, request: Request) -> Measured:
        """See `RecordFormat.read`."""
        try:
            from nptdms import TdmsFile  # pyright: ignore[reportMissingImports]
        except ImportError:
            raise missing(str(file), "npTDMS", "bench") from None
        try:
            with logged_damage("nptdms", _is_damage), TdmsFile.open(file) as source:
                return read_channels(file, _channels(source), request, _WANTED)
        except InputError:
            raise
        except Exception as error:  # npTDMS raises errors of many classes on damaged files
            raise damaged(file, _WANTED, error) from None


def _is_damage(record: logging.LogRecord) -> bool:
    """Whether a message is not only about the encoding of a text."""
    return record.levelno >= logging.WARNING and record.name != "nptdms.types"


def _channels(source: Any) -> list[Channel]:
    """Channels of a file, and the times of its waveforms."""
    channels = []
    times: dict[tuple, Channel] = {}
    for group in source.groups():
        timed = any(is_time(each.name) for each in group.channels())
        for each in group.channels():
            base = group.name if timed else _base(each.properties)
            if isinstance(base, tuple):
                name, count = f"{group.name}/time", len(each)
                if base in times:
                    name, count = times[base].name, max(count, times[base].count)
                elif name in [other.name for other in times.values()]:
                    name = f"{group.name}/{each.name}/time"
                times[base] = _times(name, count, base)
            channels.append(_channel(f"{group.name}/{each.name}", each, base))
    return [*channels, *times.values()]


def _base(properties: Any) -> tuple[str, float, float] | None:
    """Start, offset and step of a waveform, s; None for a channel that is not one."""
    if "wf_increment" not in properties:
        return None
    offset = float(properties.get("wf_start_offset", 0.0))
    return str(properties.get("wf_start_time", "")), offset, float(properties["wf_increment"])


def _times(name: str, count: int, base: tuple[str, float, float]) -> Channel:
    """Times of a waveform."""
    _, offset, step = base
    return Channel(name, count, lambda: offset + step * np.arange(count), "s", base)


def _channel(name: str, source: Any, base: tuple | str | None) -> Channel:
    unit = str(source.properties.get("unit_string", ""))
    if source.dtype.kind == "M":
        return Channel(name, len(source), lambda: seconds(source[:]), unit or "s", base)
    return Channel(name, len(source), lambda: source[:], unit, base, content_of(source.dtype))
