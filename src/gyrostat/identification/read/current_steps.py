"""Find steps of a held current, and cut a record at them where their time is unknown."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gyrostat.telemetry import Record
from gyrostat.telemetry.cuts import segmented

JUMP = 8.0
"""Change of a current from sample to sample that counts as a step, in median changes ..."""
LARGE = 0.1
"""... and relative to its largest change."""
RARE = 0.25
"""Largest fraction of the intervals with a step: a current that always changes is not held."""


def steps_of(record: Record) -> NDArray[np.int_]:
    """Intervals in which a held current steps, by the index of their first sample.

    Args:
        record: Record; the motion from one of its segments to the next does not count.
    """
    change = np.abs(np.diff(record.current))
    if record.restart is not None:
        change = np.where(record.restart[1:], 0.0, change)
    limit = max(JUMP * float(np.median(change)), LARGE * float(change.max()))
    steps = np.flatnonzero(change > limit)
    return steps if len(steps) <= RARE * len(change) else steps[:0]


def cut_at_steps(records: Sequence[Record]) -> tuple[Record, ...] | None:
    """Records whose segments end where the current steps between two samples.

    Args:
        records: Records that were cut at their gaps.

    Returns:
        The records; None if none of them has a step.
    """
    results, count = [], 0
    for record in records:
        steps = steps_of(record)
        count += len(steps)
        restart = np.zeros(len(record.time), dtype=bool)
        if record.restart is not None:
            restart |= record.restart
        restart[steps + 1] = True
        note = f"cut at {len(steps)} steps of the current between samples, whose time is unknown"
        notes = [*record.notes, note] if len(steps) else record.notes
        results.append(segmented(record, restart, record.valid, notes))
    return tuple(results) if count else None
