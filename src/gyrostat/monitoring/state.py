"""State of a monitor between two calls, as a file.

The file is replaced as a whole, so that a killed call leaves the state of the last checkpoint.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.files import whole_file
from gyrostat.monitoring.blocks import Blocks, Samples
from gyrostat.monitoring.clock import Clock
from gyrostat.monitoring.exchange import Exchange
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.windows import COLUMNS, DTYPES, Windows

_FORMAT = [
    "11",
    *COLUMNS,
    *(each.name for table in (Samples, Blocks, Exchange) for each in fields(table)),
]
"""Version and columns: a state with others is that of another version."""
START = 65_536
"""Number of bytes at the start of a file that tell it from others of its name."""


@dataclass
class Progress:
    """What was read of each file.

    Attributes:
        rows: Label of a file -> number of rows that were used.
        sizes: Label of a file that was read to its end -> its size, bytes, and its date, ns.
        sums: Label of a file -> checksum of the rows that were used.
        late: Labels of files all of whose times were reached before.
        latest: Label of the file that was read last.
        starts: Label of a file -> number of its first bytes, and their digest.
        drive: "current", "power", "torque" or "none"; empty before the first sample.
        settings: Options and wheels, as text; another call must have the same.
    """

    settings: str
    rows: dict[str, int] = field(default_factory=dict)
    sizes: dict[str, list[int]] = field(default_factory=dict)
    sums: dict[str, int] = field(default_factory=dict)
    late: list[str] = field(default_factory=list)
    latest: str = ""
    starts: dict[str, tuple[int, str]] = field(default_factory=dict)
    drive: str = ""

    def label(self, path: Path) -> str:
        """Label of a file: its name, with a number if files of this name began otherwise.

        A file that has grown, or lies in another folder, has the label that it had.

        Raises:
            InputError: The file cannot be read.
        """
        try:
            with path.open("rb") as stream:
                start = stream.read(START)
        except OSError as error:
            reason = (error.strerror or "an error").lower()
            raise InputError(f"{path}: found {reason}, expected a file of telemetry") from None
        for number in count(1):
            label = path.name if number == 1 else f"{path.name} ({number})"
            length, digest = self.starts.get(label, (len(start), _digest(start)))
            if _digest(start[:length]) == digest:
                self.starts.setdefault(label, (length, digest))
                return label
        raise AssertionError


def _digest(content: bytes) -> str:
    return sha256(content).hexdigest()


def save_state(path: Path, monitor: WheelMonitor, progress: Progress) -> None:
    """Write the state.

    Raises:
        InputError: The file cannot be written.
    """
    table = monitor.windows(complete=True)
    arrays: dict[str, Any] = {
        f"window.{name}": table[name].astype(str) if column.kind == "text" else table[name]
        for name, column in COLUMNS.items()
    }
    if monitor.tail is not None:
        arrays |= _arrays("tail", monitor.tail)
    if monitor.open_blocks:
        arrays |= _arrays("blocks", Blocks.joined(monitor.open_blocks))
    if monitor.clock.held is not None:
        arrays |= _arrays("held", monitor.clock.held)
    arrays |= _arrays("exchange", monitor.exchange)
    text = {
        "format": _FORMAT,
        "progress": vars(progress),
        "clock": {**vars(monitor.clock), "held": None},
        "drive": monitor.drive,
        "noise": [None if n is None else [n.log_ratio, n.log_time] for n in monitor.noise],
    }
    with whole_file(path) as unfinished, unfinished.open("wb") as stream:
        np.savez(stream, text=np.array(json.dumps(text)), **arrays)


def load_state(path: Path, monitor: WheelMonitor, settings: str) -> Progress:
    """Continue a monitor from a state; without a file it starts.

    Args:
        path: The file.
        monitor: New monitor, which is changed.
        settings: Options and wheels of this call.

    Raises:
        InputError: The file is damaged, or from a call with other options or wheels.
    """
    if not path.exists():
        return Progress(settings)
    try:
        with np.load(path) as content:
            arrays = {name: content[name] for name in content.files}
        text = json.loads(str(arrays.pop("text")))
        known = text["format"] == _FORMAT
        progress = Progress(**text["progress"]) if known else Progress("")
    except (OSError, EOFError, BadZipFile, ValueError, KeyError, TypeError):
        raise InputError(
            f"{path}: found a damaged or other file, expected the state of gyrostat monitor: start "
            "again with --restart and all telemetry, or give another --out"
        ) from None
    if not known or progress.settings != settings:
        other = "with other options or wheels" if known else "of another version"
        raise InputError(
            f"{path}: found the state of a call {other}, expected the same: give another --out, or "
            "start again with --restart"
        )
    monitor.clock = Clock(**text["clock"])
    monitor.drive = text["drive"]
    monitor.noise = [None if pair is None else Noise(*pair) for pair in text["noise"]]
    monitor.done = [
        Windows(
            {name: arrays[f"window.{name}"].astype(DTYPES[c.kind]) for name, c in COLUMNS.items()}
        )
    ]
    tail, blocks, held = (_part(name, arrays) for name in ("tail", "blocks", "held"))
    monitor.clock.held = Samples(**held) if held else None
    monitor.tail = Samples(**tail) if tail else None
    monitor.open_blocks = [Blocks(**blocks)] if blocks else []
    monitor.exchange = Exchange(**_part("exchange", arrays))
    return progress


def _arrays(prefix: str, table: Samples | Blocks | Exchange) -> dict[str, Any]:
    values = {f"{prefix}.{each.name}": getattr(table, each.name) for each in fields(table)}
    return {name: value for name, value in values.items() if value is not None}


def _part(prefix: str, arrays: Mapping[str, Any]) -> dict[str, Any]:
    start = f"{prefix}."
    return {name[len(start) :]: v for name, v in arrays.items() if name.startswith(start)}
