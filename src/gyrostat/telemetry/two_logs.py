"""Record of a current log and a speed log with a clock of its own."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.errors import InputError
from gyrostat.telemetry.clocks import ClockDifference, charge, clock_difference
from gyrostat.telemetry.cuts import GAP
from gyrostat.telemetry.record import CHANNELS, Record


def combine(current: Record, speed: Record) -> Record:
    """Build the record of a wheel whose current and speed were logged apart.

    The samples are those of the speed, on the clock of the current; each has the mean of the
    current, held from sample to sample, until the next speed. Other columns of the current log
    are those at its last sample.

    Args:
        current: Record with currents; its speeds are unused.
        speed: Record with speeds; its currents are unused.

    Returns:
        The record, with a note on the lag.

    Raises:
        InputError: The logs do not show their lag, or the current log has a gap.
    """
    steps = np.diff(current.time)
    widest = int(np.argmax(steps))
    if steps[widest] > GAP * float(np.median(steps)):
        raise InputError(
            f"{current.name}: found a gap of {steps[widest]:.3g} s after "
            f"{current.time[widest]:g} s, expected currents without a gap, for a speed from "
            "another log"
        )
    clock = clock_difference(current, speed)
    time = clock.times(speed.time)
    inside = (time >= current.time[0]) & (time <= current.time[-1])
    time = time[inside]
    last = np.searchsorted(current.time, time, "right") - 1
    means = np.diff(charge(current, time)) / np.diff(time)
    beside: dict[str, NDArray[np.float64] | None] = {
        name: None if (series := getattr(current, name)) is None else series[last]
        for name in CHANNELS
    }
    return replace(
        current,
        time=time,
        current=np.append(means, current.current[last[-1]]),
        speed=speed.speed[inside],
        valid=speed.valid[inside],
        notes=(*current.notes, *speed.notes, _note(speed.name, clock)),
        averaged=speed.averaged,
        **beside,
    )


def _note(name: str, clock: ClockDifference) -> str:
    """What was found and applied."""
    lag = f"{clock.lag:+.6g} +- {clock.lag_sigma:.2g} s added to the times of {name}"
    if clock.rate == 0.0:
        return f"speed: {lag}, the lag that the record shows (1 sigma)"
    rate = f"{1e6 * clock.rate:+.3g} +- {1e6 * clock.rate_sigma:.2g} ppm to its clock"
    return f"speed: {lag} at {clock.centre:.6g} s, and {rate}, as the record shows (1 sigma)"
