"""Repeats, resets and steps of the clock of telemetry."""

from dataclasses import dataclass, replace

import numpy as np

from gyrostat.monitoring.blocks import Samples

RESET = 3600.0
"""Step back above which the clock was reset, s; samples of a smaller step are repeats."""

AFTER_RESET = 120.0
"""Time that a reset is taken to last, s."""


@dataclass
class Clock:
    """Clock of the telemetry, which only goes forward.

    Attributes:
        last: Time of the last sample used, on the corrected clock, s.
        previous: Time of the last sample of the file that is being read, s; NaN at its start.
        offset: Corrected clock minus clock of the telemetry, s.
        resets: Number of resets.
        repeats: Number of samples left out because their time was past.
        without_time: Number of samples left out because they have no time.
    """

    last: float = -np.inf
    previous: float = np.nan
    offset: float = 0.0
    resets: int = 0
    repeats: int = 0
    without_time: int = 0

    def begin_file(self) -> None:
        """Take the next sample as the first one of a file.

        What it repeats of earlier files is left out, however long it is.
        """
        self.previous = np.nan

    def corrected(self, samples: Samples) -> Samples:
        """Samples on the corrected clock, with increasing times.

        How long a reset took is not known: the time goes on `AFTER_RESET` later, so that no block
        spans it.

        Args:
            samples: Samples in the order of the telemetry.
        """
        finite = np.isfinite(samples.time)
        if not finite.all():
            self.without_time += int(np.sum(~finite))
            samples = samples.part(finite)
        if not len(samples):
            return samples
        time = samples.time + self.offset
        step = np.diff(time, prepend=time[0] if np.isnan(self.previous) else self.previous)
        for at in np.flatnonzero(step < -RESET):
            before = time[at - 1] if at else self.previous
            shift = before + AFTER_RESET - time[at]
            time[at:] += shift
            self.offset += shift
            self.resets += 1
        self.previous = float(time[-1])
        latest = np.maximum.accumulate(np.append(self.last, time))
        fresh = time > latest[:-1]
        self.repeats += int(np.sum(~fresh))
        self.last = float(latest[-1])
        corrected = (
            samples if self.offset == 0.0 and not self.resets else replace(samples, time=time)
        )
        return corrected if fresh.all() else corrected.part(fresh)
