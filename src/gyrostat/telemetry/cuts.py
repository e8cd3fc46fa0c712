"""Split a record at unusable intervals: gaps, a frozen tachometer, a clipped current."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gyrostat.telemetry.record import CHANNELS, Record
from gyrostat.telemetry.signals import runs, scatter

GAP = 10.0
"""Largest interval between two samples that is not a gap, in usual sample intervals."""
VARYING = 0.05
"""Largest fraction of exact repetitions in a signal that varies from sample to sample."""
FROZEN = 8
"""Smallest number of successive repetitions by which a varying tachometer counts as frozen."""
DROPPED = 3
"""Smallest number of zeros between speeds far from zero that count as a tachometer dropout."""
FAR = 10.0
"""Speed that counts as far from zero, in standard deviations of the noise."""
CLIPPED, CLIPPED_RUNS = 3, 2
"""Smallest number of successive samples at the largest current, and smallest number of such runs,
for a clipped current."""
LEAST = 1e-9
"""Noise, relative to the largest speed, below which repeated speeds are due to rounding."""


def _frozen_samples(record: Record) -> NDArray[np.bool_]:
    """Whether the speed only repeats the previous one because the tachometer is frozen, (N,)."""
    indices = np.flatnonzero(record.valid)
    speed = record.speed[indices]
    frozen = np.zeros(len(record.time), dtype=bool)
    if len(speed) < FROZEN:
        return frozen
    noise = scatter(speed)
    if noise <= LEAST * float(np.max(np.abs(speed))):
        return frozen
    repeats = np.concatenate([[False], speed[1:] == speed[:-1]])
    long = [(a, b) for a, b in runs(repeats) if b - a >= FROZEN]
    usual = repeats & (speed != 0.0)
    for first, last in long:
        usual[first:last] = False
    if np.mean(usual) < VARYING:
        for first, last in long:
            if speed[first] != 0.0:
                frozen[indices[first:last]] = True
    for first, last in runs(speed == 0.0):
        inside = first > 0 and last < len(speed) and last - first >= DROPPED
        if inside and min(abs(speed[first - 1]), abs(speed[last])) > FAR * noise:
            frozen[indices[first:last]] = True
    return frozen


def _clipped_samples(current: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether the current is at the limit of its measurement, (N,)."""
    at = np.abs(current) == np.max(np.abs(current))
    long = [(a, b) for a, b in runs(at) if b - a >= CLIPPED]
    unsaturated = ~at & (current != 0.0)
    repeats = np.concatenate([[False], current[1:] == current[:-1]])
    varies = unsaturated.sum() > FROZEN and np.mean(repeats[unsaturated]) < VARYING
    clipped = np.zeros(len(current), dtype=bool)
    if varies and len(long) >= CLIPPED_RUNS:
        for first, last in long:
            clipped[first:last] = True
    return clipped


def cut(record: Record) -> Record:
    """Split a record into segments wherever its current or speed is unknown.

    A gap of more than `GAP` usual sample intervals and an interval of clipped current end a
    segment: the speed after it has its own initial value. Speeds of a frozen tachometer are marked
    missing. Samples of segments with fewer than two speeds are omitted.

    Args:
        record: Record as read.

    Returns:
        The record with `restart` and with notes on the changes; the same record if it was split
        before.
    """
    if record.restart is not None:
        return record
    notes = list(record.notes)
    frozen = _frozen_samples(record)
    if frozen.any():
        count = len(runs(frozen))
        notes.append(f"tachometer frozen: {int(frozen.sum())} samples masked ({count} intervals)")
    clipped = _clipped_samples(record.current)
    if clipped.any():
        level = float(np.max(np.abs(record.current)))
        notes.append(
            f"current clipped at {level:.4g} A: cut at {int(clipped.sum())} samples "
            f"({len(runs(clipped))} intervals)"
        )
    steps = np.diff(record.time)
    usual = float(np.median(steps))
    gaps = steps > GAP * usual
    if gaps.any():
        notes.append(
            f"{int(gaps.sum())} gaps longer than {GAP:g} usual sample times ({usual:.3g} s): split "
            "into segments with their own initial speed"
        )
    restart = np.concatenate([[False], gaps | clipped[:-1]])
    return segmented(record, restart, record.valid & ~frozen, notes)


def segmented(
    record: Record, restart: NDArray[np.bool_], valid: NDArray[np.bool_], notes: Sequence[str]
) -> Record:
    """Split a record into segments; those with fewer than two speeds are omitted.

    Args:
        record: Record.
        restart: Whether a segment begins at the sample, (N,).
        valid: Whether the speed sample is present, (N,).
        notes: Notes of the result.

    Returns:
        The record with `restart`; the same record if no segment has two speeds.
    """
    if record.averaged:
        # this mean covers an interval outside the segment
        valid = valid & ~restart
    mask = np.ones(len(restart), dtype=bool)
    starts = [0, *np.flatnonzero(restart).tolist(), len(restart)]
    for first, last in pairwise(starts):
        if valid[first:last].sum() < 2:
            mask[first:last] = False
    if mask.sum() < 2:
        return record
    # the samples after an omitted segment also start a new segment
    fresh = np.concatenate([[False], ~mask[:-1]]) | restart
    fields = {
        name: None if (series := getattr(record, name)) is None else series[mask]
        for name in ("time", "current", *CHANNELS)
    }
    fresh = fresh[mask]
    fresh[0] = False
    return replace(
        record,
        **fields,
        speed=np.where(valid, record.speed, np.nan)[mask],
        valid=valid[mask],
        restart=fresh,
        notes=tuple(notes),
    )
