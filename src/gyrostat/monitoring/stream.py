"""Monitor of the wheels of a spacecraft: samples in, rows of the window table out.

It keeps the samples of the block that is not complete, the blocks of the window that is not
complete, and the rows: its memory does not grow with the number of samples.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Blocks, Samples, blocks_of
from gyrostat.monitoring.clock import Clock
from gyrostat.monitoring.exchange import Exchange
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.verdict import FEWEST
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.monitoring.window import window_row
from gyrostat.monitoring.windows import Windows

DAY = 86400.0
BLOCK = 60.0
PIECE = 32768
"""Samples that are taken at once: of these, four wheels fit into the cache of a processor."""
KEPT = 31 * 2**20
"""Size of an array that is made and freed once, bytes; glibc learns from at most 32 MiB."""
MANY = 1000
"""Rows that are kept as rows before they become a table, which needs less memory."""


@dataclass(eq=False)
class WheelMonitor:
    """Monitor; `add` and `add_sample` take telemetry, `windows` gives the table so far.

    Any division of the telemetry into calls gives the same table.

    Attributes:
        known: What is known of the wheels beforehand.
        window: Length of a window, s; windows begin at its multiples.
        block: Length of a block, s.
        drive: What the drive of the samples was in the telemetry: "current", "power" (see
            `gyrostat.monitoring.power`), "torque" or "none".
        clock: Clock of the telemetry.
        done: Rows of complete windows, in several tables.
        rows: Rows of the latest complete windows, which are not in `done` yet.
        tail: Samples of the block that is not complete.
        open_blocks: Blocks of the window that is not complete.
        noise: Noise of each wheel in its last valid window.
        exchange: Exchange of momentum, as learnt from the windows so far.
        latest: The same with the window that is not complete, after `windows`.
    """

    known: KnownWheels
    window: float = DAY
    block: float = BLOCK
    drive: str = "current"
    clock: Clock = field(default_factory=Clock)
    done: list[Windows] = field(default_factory=list)
    rows: list[dict[str, Any]] = field(default_factory=list)
    tail: Samples | None = None
    open_blocks: list[Blocks] = field(default_factory=list)
    noise: list[Noise | None] = field(default_factory=list)
    exchange: Exchange = field(default_factory=Exchange)
    latest: Exchange = field(default_factory=Exchange)
    _singles: list[Samples] = field(default_factory=list, repr=False)

    def __post_init__(self):
        # glibc keeps what is freed, up to twice the largest mapping freed so far, and otherwise
        # returns it to the system: to map it again takes a quarter of the time of the monitor
        np.empty(KEPT, np.uint8)
        if not self.noise:
            self.noise = [None] * len(self.known.wheels)
        share = self.window / self.block
        if not (share >= FEWEST and abs(share - round(share)) < 1e-9):
            raise InputError(
                f"window: found {self.window:g} s, expected a multiple of {self.block:g} s of at "
                f"least {FEWEST * self.block:g} s"
            )

    def begin_file(self) -> None:
        """Take the next sample as the first one of a file; see `Clock.begin_file`."""
        self._flush()
        self.clock.begin_file()

    def add(self, samples: Samples) -> None:
        """Take samples in.

        Args:
            samples: Samples in the order of the telemetry; repeats and steps of the clock are
                corrected (`gyrostat.monitoring.clock`).

        Raises:
            InputError: A column has another shape.
        """
        self._flush()
        samples.check(len(self.known.wheels))
        for first in range(0, len(samples), PIECE):
            self._add(samples.part(slice(first, first + PIECE)))

    def add_sample(
        self,
        time: float,
        speed: Vector,
        drive: Vector,
        rate: Vector | None = None,
        temperature: Vector | None = None,
        mode: float | None = None,
    ) -> None:
        """Take one sample in; it is used when its block is complete.

        Args:
            time: s.
            speed: Wheel speeds, (wheels,), rad/s.
            drive: Motor currents, (wheels,), A, also from powers, or commanded torques over nominal
                motor constants.
            rate: Body rate, (3,), rad/s.
            temperature: Temperatures, (wheels,), °C.
            mode: Number of the mode.

        Raises:
            InputError: A value has another shape.
        """
        optional = {"rate": rate, "temperature": temperature, "mode": mode}
        sample = Samples(
            np.array([time], float),
            np.atleast_2d(np.asarray(speed, float)),
            np.atleast_2d(np.asarray(drive, float)),
            **{name: None if v is None else np.array([v], float) for name, v in optional.items()},
        )
        sample.check(len(self.known.wheels))
        first = self._singles[0].time[0] if self._singles else time
        if not 0.0 <= time - first < self.block:
            self._flush()
        self._singles.append(sample)

    def windows(self, *, complete: bool = False) -> Windows:
        """Window table so far.

        Args:
            complete: Whether to leave out the window that is not complete.
        """
        self._flush()
        rows = [*self.rows, *([] if complete else self._provisional())]
        return Windows.joined([*self.done, Windows.of(rows)])

    def _flush(self) -> None:
        if self._singles:
            singles, self._singles = self._singles, []
            self._add(Samples.joined(singles))

    def _add(self, samples: Samples) -> None:
        samples = self._without_modes(self.clock.corrected(samples))
        if not len(samples):
            return
        if self.tail is not None:
            samples = Samples.joined([self.tail, samples])
        blocks, self.tail = blocks_of(samples, self.block, self.known.speed_resolution)
        while len(blocks):
            number = np.floor(blocks.start / self.window + 1e-12)
            current = self._number() if self.open_blocks else number[0]
            if number[0] > current:
                self._close()
                continue
            inside = number <= current
            self.open_blocks.append(blocks.part(inside))
            blocks = blocks.part(~inside)
            if len(blocks):
                self._close()

    def _number(self) -> float:
        return float(np.floor(self.open_blocks[0].start[0] / self.window + 1e-12))

    def _without_modes(self, samples: Samples) -> Samples:
        """Samples without drive and rates in modes whose telemetry is not used.

        The samples stay, so that blocks with some of them are left out rather than closed up.
        """
        if samples.mode is None or not self.known.modes_left_out:
            return samples
        left_out = np.isin(samples.mode, self.known.modes_left_out)
        if not left_out.any():
            return samples
        drive = np.where(left_out[:, None], np.nan, samples.drive)
        rate = samples.rate
        if rate is not None:
            rate = np.where(left_out[:, None], np.nan, rate)
        return replace(samples, drive=drive, rate=rate)

    def _close(self) -> None:
        """Estimate the window that is complete."""
        rows, self.noise, self.exchange = self._rows()
        self.rows += rows
        if len(self.rows) > MANY:
            self.done.append(Windows.of(self.rows))
            self.rows = []
        self.open_blocks = []

    def _provisional(self) -> list[dict[str, Any]]:
        """Rows of the window that is not complete, if it has enough blocks."""
        self.latest = self.exchange
        if sum(map(len, self.open_blocks)) < FEWEST:
            return []
        rows, _, self.latest = self._rows()
        return rows

    def _rows(self) -> tuple[list[dict[str, Any]], list[Noise | None], Exchange]:
        blocks = Blocks.joined(self.open_blocks)
        self.open_blocks = [blocks]
        total, blocks = len(blocks), blocks.part(blocks.whole)
        start = self._number() * self.window
        columns, exchange = self.exchange.window(blocks, self.known)
        results = [
            window_row(
                blocks,
                self.known,
                wheel,
                (start, start + self.window),
                total=total,
                length=self.block,
                drive=self.drive,
                noise=self.noise[wheel],
                exchange=columns[wheel],
            )
            for wheel in range(len(self.known.wheels))
        ]
        return [row for row, _ in results], [noise for _, noise in results], exchange
