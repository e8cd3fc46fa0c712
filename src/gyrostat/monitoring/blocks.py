"""Sums over blocks of telemetry, by default a minute each, computed as the samples arrive.

A block begins with the first sample at or after a multiple of its length, and ends with the first
sample of the next block, which both share. Its change of speed is thus exact up to the rounding of
two samples, and integrals follow the trapezoidal rule with a correction at the ends. Blocks with a
gap, a change of mode or too few samples are not whole, and only counted. The result is the same for
any division of the telemetry into pieces.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.core.types import Matrix, Vector
from gyrostat.monitoring.differences import (
    calm_noise,
    change_inwards,
    deceleration,
    noise,
    steps,
)

SLOW = 1e-9
"""Speed below which a wheel rests, rad/s, beside the rounding of its tachometer."""
NO_STEP = 1e-6
"""Difference of two values of the drive, over the larger one, below which it is no resolution but
an error of their arithmetic."""


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of telemetry, in SI units; NaN where a value is missing.

    Attributes:
        time: Increasing, (N,), s.
        speed: (N, wheels), rad/s.
        drive: Motor current, also from the power, or commanded torque over the nominal motor
            constant, (N, wheels), A.
        rate: Body rate, (N, 3), rad/s, or None.
        temperature: (N, wheels), °C, or None.
        mode: (N,), or None.
    """

    time: Vector
    speed: Matrix
    drive: Matrix
    rate: Matrix | None = None
    temperature: Matrix | None = None
    mode: Vector | None = None

    def __len__(self) -> int:
        """Number of samples."""
        return self.time.size

    def check(self, wheels: int) -> None:
        """Check the shapes for a number of wheels; raises `InputError`."""
        count = (len(self),)
        of_wheels = (*count, wheels)
        shapes = {"time": count, "speed": of_wheels, "drive": of_wheels, "rate": (*count, 3)}
        shapes |= {"temperature": of_wheels, "mode": count}
        for name, shape in shapes.items():
            values = getattr(self, name)
            if values is not None and np.shape(values) != shape:
                raise InputError(f"{name}: found shape {np.shape(values)}, expected {shape}")

    def part(self, rows: slice | NDArray[np.bool_]) -> "Samples":
        """Selected samples."""
        selected: dict[str, Any] = {}
        for each in fields(self):
            values = getattr(self, each.name)
            selected[each.name] = None if values is None else values[rows]
        return Samples(**selected)

    def checksum(self) -> int:
        """Sum over the samples of a hash of each, modulo 2**64: the same for any division."""
        columns = [getattr(self, each.name) for each in fields(self)]
        present = np.column_stack([each for each in columns if each is not None])
        bits = present.astype(np.float64).view(np.uint64)
        # sums of bits alone are the same with columns or rows exchanged
        row = bits @ np.arange(1, 2 * bits.shape[1], 2, dtype=np.uint64)
        row ^= row >> np.uint64(32)
        row *= np.uint64(0x9E3779B97F4A7C15)
        row ^= row >> np.uint64(29)
        return int(row.sum())

    @staticmethod
    def joined(parts: "Sequence[Samples]") -> "Samples":
        """Samples of several tables, in order; columns that one of them lacks are lacking."""
        joined: dict[str, Any] = {}
        for each in fields(Samples):
            columns: list[Any] = [getattr(part, each.name) for part in parts]
            present = all(column is not None for column in columns)
            joined[each.name] = np.concatenate(columns) if present else None
        return Samples(**joined)


@dataclass(frozen=True, eq=False)
class Blocks:
    """Sums over B blocks.

    Attributes:
        start: Time of the first sample, (B,), s.
        length: Time to the first sample of the next block, (B,), s.
        count: Number of samples, (B,).
        change: Change of speed, (B, wheels), rad/s.
        other_change: The same between the samples after these two, (B, wheels), rad/s.
        drive: Mean of the drive, (B, wheels), A.
        drive_change: Change of the drive, (B, wheels), A.
        scatter: Rms difference of neighbouring values of the drive over √2, (B, wheels), A.
        direction: Mean sign of the speed, (B, wheels).
        speed: Mean speed, (B, wheels), rad/s.
        slowest: Least speed without sign, (B, wheels), rad/s.
        deceleration: Largest deceleration, the mean over `BRAKING` seconds of the block,
            (B, wheels), rad/s²; negative if the wheel accelerates throughout.
        speed_noise: Rms of the noise of a speed sample, from second differences, (B, wheels),
            rad/s.
        drive_noise: Rms of the noise of a drive sample, from fourth differences, (B, wheels), A.
        drive_steps: Largest step of the drive between two samples, or what looks like one in its
            noise, (B, wheels), A.
        slow_drive: Largest drive without sign while the wheel rests, (B, wheels), A; 0 if never.
        rest: Share of samples at rest, (B, wheels).
        step: Least difference of neighbouring values of the drive above `NO_STEP`, (B, wheels), A:
            its resolution if it is rounded; infinite if the drive does not change.
        turn: Change of the body rate, (B, 3), rad/s; NaN without rates.
        rate: Mean body rate, (B, 3), rad/s; NaN without rates.
        temperature: Mean temperature, (B, wheels), °C; NaN without.
        whole: Whether it has no gap, no change of mode and enough samples, (B,).
    """

    start: Vector
    length: Vector
    count: NDArray[np.int64]
    change: Matrix
    other_change: Matrix
    drive: Matrix
    drive_change: Matrix
    scatter: Matrix
    direction: Matrix
    speed: Matrix
    slowest: Matrix
    deceleration: Matrix
    speed_noise: Matrix
    drive_noise: Matrix
    drive_steps: Matrix
    slow_drive: Matrix
    rest: Matrix
    step: Matrix
    turn: Matrix
    rate: Matrix
    temperature: Matrix
    whole: NDArray[np.bool_]

    def __len__(self) -> int:
        """Number of blocks."""
        return self.start.size

    @property
    def gaps(self) -> NDArray[np.bool_]:
        """Whether blocks are missing between a block and the next one, (B - 1,)."""
        return np.diff(self.start) > 1.5 * self.length[:-1]

    def part(self, rows: slice | NDArray[np.bool_]) -> "Blocks":
        """Selected blocks."""
        if isinstance(rows, np.ndarray) and rows.all():
            return self
        return Blocks(**{each.name: getattr(self, each.name)[rows] for each in fields(self)})

    @staticmethod
    def joined(parts: "list[Blocks]") -> "Blocks":
        """Blocks of several tables, in order."""
        return Blocks(
            **{
                each.name: np.concatenate([getattr(part, each.name) for part in parts])
                for each in fields(Blocks)
            }
        )


def blocks_of(samples: Samples, length: float, resolution: float) -> tuple[Blocks, Samples]:
    """Blocks that the samples complete, and the samples of the block that is not complete yet.

    Args:
        samples: Samples from the start of a block.
        length: Length of a block, s.
        resolution: Resolution of the speed, rad/s.
    """
    number = np.floor(samples.time / length)
    starts = np.flatnonzero(np.diff(number, prepend=-np.inf))
    tail = samples.part(slice(int(starts[-1]), None)) if starts.size else samples
    if starts.size < 2:
        return _blocks(samples, np.zeros(1, np.int64), length, resolution).part(slice(0, 0)), tail
    # the sample after the first one of the next block belongs to a block's other change; where it
    # has not arrived yet, the block waits
    if starts[-1] + 1 >= len(samples):
        starts = starts[:-1]
        tail = samples.part(slice(int(starts[-1]), None))
        if starts.size < 2:
            return _blocks(samples, starts, length, resolution).part(slice(0, 0)), tail
    return _blocks(samples, starts, length, resolution), tail


def _blocks(
    samples: Samples, starts: NDArray[np.int64], length: float, resolution: float
) -> Blocks:
    """Blocks between the samples `starts`."""
    time, speed, drive = samples.time, samples.speed, samples.drive
    first, last = starts[:-1], starts[1:]
    if not first.size:
        return _no_blocks(speed.shape[1])
    end = int(last[-1]) + 1
    step = np.diff(time[:end])
    span = time[last] - time[first]
    count = last - first

    def total(values: Matrix) -> Matrix:
        return np.add.reduceat(values, first, axis=0)

    def mean(values: Matrix) -> Matrix:
        pair = 0.5 * (values[1:end] + values[: end - 1])
        pair *= step.reshape(-1, *(1,) * (values.ndim - 1))
        # the first correction of Gregory's rule: trapezoids of 10 s make the current of a slew too
        # small by half a percent
        slopes = step[first, None] * change_inwards(values, first, last)
        slopes += step[last - 1, None] * change_inwards(values, last, first)
        return (total(pair) + slopes / 12.0) / span.reshape(-1, *(1,) * (values.ndim - 1))

    inside = slice(0, end - 1)
    magnitude = np.abs(speed[inside])
    slow = magnitude <= max(SLOW, 0.51 * resolution)
    jump = np.abs(np.diff(drive[:end], axis=0))
    floor = NO_STEP * np.maximum(np.abs(drive[1:end]), np.abs(drive[: end - 1]))
    finest = np.minimum.reduceat(np.where(jump > floor, jump, np.inf), first, axis=0)
    jump *= jump
    bend = np.diff(drive[: end + 1], n=2, axis=0)
    wheels = speed.shape[1]
    turn = rate = np.full((first.size, 3), np.nan)
    if samples.rate is not None:
        rate = mean(samples.rate)
        turn = samples.rate[last] - samples.rate[first]
    warm = np.full((first.size, wheels), np.nan)
    if samples.temperature is not None:
        warm = total(samples.temperature[inside]) / count[:, None]
    longest = np.maximum.reduceat(step, first)
    whole = (count >= 4) & (longest <= 0.25 * length) & (span < 1.5 * length)
    whole &= time[last + 1] - time[last] <= 0.25 * length
    if samples.mode is not None:
        changed = np.diff(samples.mode[:end]) != 0
        whole &= ~np.logical_or.reduceat(changed, first)
    return Blocks(
        start=time[first],
        length=span,
        count=count.astype(np.int64),
        change=speed[last] - speed[first],
        other_change=speed[last + 1] - speed[first + 1],
        drive=mean(drive),
        drive_change=drive[last] - drive[first],
        scatter=np.sqrt(0.5 * total(jump) / count[:, None]),
        direction=mean(np.sign(speed)),
        speed=mean(speed),
        slowest=np.minimum.reduceat(magnitude, first, axis=0),
        deceleration=deceleration(time[:end], np.abs(speed[:end]), first, last),
        speed_noise=noise(np.diff(speed[: end + 1], n=2, axis=0), first, last),
        drive_noise=calm_noise(bend, first, last),
        drive_steps=steps(bend, first, last),
        slow_drive=np.maximum.reduceat(np.where(slow, np.abs(drive[inside]), 0.0), first, axis=0),
        rest=total(slow.astype(float)) / count[:, None],
        step=finest,
        turn=turn,
        rate=rate,
        temperature=warm,
        whole=whole,
    )


def _no_blocks(wheels: int) -> Blocks:
    flat = dict.fromkeys(("start", "length", "count", "whole"), (0,))
    shapes = {**flat, "turn": (0, 3), "rate": (0, 3)}
    kinds = {"count": np.int64, "whole": np.bool_}
    empty: dict[str, Any] = {
        each.name: np.zeros(shapes.get(each.name, (0, wheels)), kinds.get(each.name, float))
        for each in fields(Blocks)
    }
    return Blocks(**empty)
