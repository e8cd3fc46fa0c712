"""Repeats, resets, steps and wild times of the clock of telemetry."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.blocks import Samples

RESET = 3600.0
"""Step above which the clock was reset (back) or telemetry is missing (ahead), s; samples of a
smaller step back are repeats."""
CONFIRMING = 10
"""Samples that must follow one another after such a step; fewer of them have wild times."""
AFTER_RESET = 120.0
"""Time that a reset is taken to last, s."""


@dataclass
class Clock:
    """Clock of the telemetry, which only goes forward.

    Attributes:
        first: Time of the first sample used, s.
        last: Time of the last sample used, on the corrected clock, s.
        previous: Time of the last sample of the file that is being read, s; NaN at its start.
        offset: Corrected clock minus clock of the telemetry, s.
        resets: Number of resets.
        repeats: Number of samples left out because their time was past.
        wild: Number of samples left out because the samples around them have other times.
        without_time: Number of samples left out because they have no time.
        held: Samples after a step that too few samples have confirmed so far.
    """

    first: float = np.nan
    last: float = -np.inf
    previous: float = np.nan
    offset: float = 0.0
    resets: int = 0
    repeats: int = 0
    wild: int = 0
    without_time: int = 0
    held: Samples | None = None

    def begin_file(self) -> None:
        """Take the next sample as the first one of a file.

        What it repeats of earlier files is left out, however long it is.
        """
        self.previous = np.nan

    def corrected(self, samples: Samples) -> Samples:
        """Samples on the corrected clock, with increasing times.

        A step back is a reset, and a step ahead a gap, if `CONFIRMING` samples follow one another
        after it; until then they are held. How long a reset took is not known: the time goes on
        `AFTER_RESET` later, so that no block spans it.

        Args:
            samples: Samples in the order of the telemetry.
        """
        finite = np.isfinite(samples.time)
        if not finite.all():
            self.without_time += int(np.sum(~finite))
            samples = samples.part(finite)
        if self.held is not None:
            samples, self.held = Samples.joined([self.held, samples]), None
        if not len(samples):
            return samples
        time = samples.time + self.offset
        used = self._follow(samples, time)
        latest = np.maximum.accumulate(np.append(self.last, np.where(used, time, -np.inf)))
        fresh = used & (time > latest[:-1])
        self.repeats += int(np.sum(used & ~fresh))
        if np.isnan(self.first) and fresh.any():
            self.first = float(time[fresh][0])
        self.last = float(latest[-1])
        corrected = (
            samples if self.offset == 0.0 and not self.resets else replace(samples, time=time)
        )
        return corrected if fresh.all() else corrected.part(fresh)

    def _follow(self, samples: Samples, time: Vector) -> NDArray[np.bool_]:
        """Which samples have a time that others confirm; `time` is corrected by resets in place."""
        used = np.ones(time.size, bool)
        steps = np.flatnonzero(np.abs(np.diff(time)) > RESET) + 1
        starts = [0, *steps.tolist()]
        for first, end in zip(starts, [*starts[1:], time.size], strict=True):
            step = time[first] - self.previous
            # a file that goes on where the last one ended needs no confirmation
            if np.isnan(step) and 0.0 < time[first] - self.last <= RESET:
                step = 0.0
            if not abs(step) <= RESET:
                if end - first < CONFIRMING and not self._is_between(time, end, end - 1):
                    used[first:end] = False
                    if end == time.size:
                        self.held = samples.part(slice(first, end))
                    else:
                        self.wild += end - first
                    continue
                if step < 0.0:
                    shift = AFTER_RESET - step
                    time[first:] += shift
                    self.offset += shift
                    self.resets += 1
            self.previous = float(time[end - 1])
        return used

    def _is_between(self, time: Vector, after: int, at: int) -> bool:
        """Whether a time lies between that of the last sample used and that of a later one."""
        return after < time.size and self.previous < time[at] < time[after]
