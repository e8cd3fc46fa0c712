"""Pool the samples of a dense record, if no information is lost."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.telemetry.record import CHANNELS, Record
from gyrostat.telemetry.signals import scatter

MANY = 50_000
"""Largest number of samples of a record that is not pooled."""
ENOUGH = 25_000
"""Smallest number of means in a pooled record."""
BLOCKS = 1000
"""Number of blocks whose mean speeds give the accelerations."""
STILL = 0.2
"""Largest change of the speed over a pooled interval, in standard deviations of its noise."""
FAST = 0.99
"""Quantile of the accelerations that counts as the largest."""


def _largest_pool(record: Record) -> int:
    """Largest number of samples that may be pooled into one; 1 for no pooling."""
    if record.time.size <= MANY:
        return 1
    speed = record.speed[record.valid]
    time = record.time[record.valid]
    noise = scatter(speed)
    block = len(speed) // BLOCKS
    means, at = (_means(v[: block * BLOCKS], block) for v in (speed, time))
    rate = np.abs(np.diff(means) / np.diff(at))
    fastest = float(np.quantile(rate, FAST))
    usual = float(np.median(np.diff(record.time)))
    largest = STILL * noise / (fastest * usual) if fastest > 0.0 else np.inf
    return max(1, int(min(largest, record.time.size / ENOUGH)))


def _means(values: NDArray[np.float64], size: int) -> NDArray[np.float64]:
    return values.reshape(-1, size).mean(axis=1)


def pool(record: Record) -> tuple[Record, int]:
    """Replace a dense record by means over intervals in which the speed hardly changes.

    Within an interval, the mean of the current has the same effect as the current, and the mean of
    the speed is compared with the mean of the model. Samples at the end of a segment that do not
    fill an interval are omitted.

    Args:
        record: Record split at its gaps.

    Returns:
        The record, or means of it; and the number of samples per mean.
    """
    size = _largest_pool(record)
    if size == 1:
        return record, 1
    parts: dict[str, list[NDArray]] = {}
    speed = np.where(record.valid, record.speed, 0.0)
    present = record.valid.astype(np.float64)
    for k, segment in enumerate(record.segments):
        count = (segment.stop - segment.start - 1) // size
        if count < 2:
            continue
        edges = segment.start + size * np.arange(count + 1)
        inside = slice(edges[0], edges[-1])
        after = slice(edges[0] + 1, edges[-1] + 1)
        weight, total = _means(present[after], size), _means(speed[after], size)
        if not record.averaged:
            # means of the speed at both ends of each sample interval
            weight = 0.5 * (weight + _means(present[inside], size))
            total = 0.5 * (total + _means(speed[inside], size))
        valid = np.append(False, weight > 0.5)
        columns = {
            "time": record.time[edges],
            "current": np.append(
                _means((record.current[inside] * np.diff(record.time)[inside]), size)
                * size
                / np.diff(record.time[edges]),
                record.current[edges[-1]],
            ),
            "speed": np.where(valid, np.append(0.0, total / np.maximum(weight, 0.5)), np.nan),
            "valid": valid,
            "restart": np.append(k > 0, np.zeros(count, dtype=bool)),
        }
        for name in CHANNELS:
            series = getattr(record, name)
            if series is not None:
                columns[name] = series[edges]
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    if not parts:
        return record, 1
    fields = {name: np.concatenate(values) for name, values in parts.items()}
    fields["restart"][0] = False
    note = f"{record.time.size} samples pooled to {fields['time'].size} means of {size}"
    return replace(record, **fields, averaged=True, notes=(*record.notes, note)), size
