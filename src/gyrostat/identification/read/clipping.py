"""Detect a clipped current that is constant between its steps, by the equation of motion.

A current with noise shows its limit by exact repetitions (`gyrostat.telemetry.cut`). Steps without
noise repeat anyway: that several of them have exactly the same largest size may be intended. They
are clipped if the wheel accelerates as under a larger current.
"""

import numpy as np

from gyrostat.identification.read.findings import Finding, fault_finding
from gyrostat.identification.read.signs import (
    FEWEST_WINDOWS,
    WINDOWS,
    filled_speed,
    motion_regression,
)
from gyrostat.telemetry import Record
from gyrostat.telemetry.cuts import segmented
from gyrostat.telemetry.signals import runs

STRETCHES = (2, 16)
"""Smallest and largest number of intervals at the largest current that may be clipped."""
EXCEEDED, BELOW = 0.1, -0.05
"""Smallest excess of a true current over its limit that is reported, and smallest excess of any
interval, relative to the limit. A drift of friction by 10 % changes the torque by less."""
CLEAR_F = 10.0
"""Smallest F statistic of the regression with the true currents against that without: a hundred
thousandth of records without clipping reach it by noise."""


def _stretches(record: Record) -> list[tuple[int, int]]:
    """First index, and index after the last, of each interval of largest current of either sign."""
    largest = np.max(np.abs(record.current))
    return sorted(runs(record.current == largest) + runs(record.current == -largest))


def clipped_current(record: Record) -> Finding | None:
    """Test whether the steps of largest current were larger than recorded.

    Args:
        record: Record as measured.

    Returns:
        The finding; None if the recorded current explains the motion.
    """
    stretches, count = _stretches(record), len(record.time)
    fewest, most = STRETCHES
    constant = sum(last - first for first, last in stretches) == count
    if constant or not fewest <= len(stretches) <= most or count < FEWEST_WINDOWS:
        return None
    columns = np.zeros((count, len(stretches)))
    for k, (first, last) in enumerate(stretches):
        columns[first:last, k] = record.current[first:last]
    speed = filled_speed(record)
    _, plain = motion_regression(record.time, record.current, speed)
    coefficients, better = motion_regression(record.time, record.current, speed, columns)
    freedom = min(WINDOWS, count - 1) - len(coefficients)
    gain = (plain - better) / len(stretches)
    if coefficients[0] == 0.0 or freedom < 1 or not gain * freedom > CLEAR_F * better:
        return None
    excess = coefficients[3:] / coefficients[0]
    if np.min(excess) < BELOW or np.max(excess) < EXCEEDED:
        return None
    evidence = WINDOWS * float(np.log(plain / max(better, np.finfo(float).tiny)))
    limit = float(np.max(np.abs(record.current)))
    title = f"current of {record.name} clipped at {limit:.4g} A: excess, share of the limit"
    return fault_finding("clipped_current", title, float(np.max(excess)), evidence)


def without_clipped(record: Record) -> Record:
    """Remove the intervals of clipped current from a record.

    Args:
        record: Record with a clipped current.
    """
    stretches = _stretches(record)
    restart = record.restart
    after = np.zeros(len(record.time), dtype=bool) if restart is None else restart.copy()
    for first, last in stretches:
        after[first + 1 : last + 1] = True
    samples = sum(last - first for first, last in stretches)
    note = f"current clipped: cut at {samples} samples ({len(stretches)} intervals)"
    return segmented(record, after, record.valid, (*record.notes, note))
