"""Test for feedback: whether the current answers earlier residuals of the speed.

The residual is that of a linear prediction of the speed from its past and that of the current. It
does not depend on a fit, which may fail for a record in closed loop.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import betainc

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.statistics import quantum
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import NORMAL_MAD

LAGS = 5
"""Residuals before each current that may drive it."""
MEMORY = 10
"""Currents and speeds from which the next ones are predicted."""
FEWEST = 200
"""Smallest number of samples of a record that is tested."""
MOST = 200_000
"""Largest number of samples of a record that are tested: more cost time and decide nothing else."""
PIECE = 10_000
"""Samples that follow each other in a record of more than `MOST`."""
CLIP = 3.0
"""Largest deviation from a prediction that counts, in its standard deviations."""
PREDICTABLE = 1e-4
"""Deviation of the current from its prediction, relative to its scatter, that counts as none: the
current is a programme, such as steps or sines."""
SHIFTS = 199
"""Shifts between current and residuals with which the statistic is compared."""
LEVEL = 0.01
"""Share of all shifts that may have a larger statistic."""
SURE = 1e-4
"""Probability that no shift has without a relation; one that has shows what the F test lacks, such
as periods that current and residuals share."""
STRONG = 1e-3
"""Largest probability of the F test."""


@dataclass(frozen=True)
class Feedback(Described):
    """Result of the test.

    Attributes:
        found: Whether the current answers earlier residuals, or the loop was stated as closed.
        probability: Probability of the F test of the clearest record, times their number; 1 if
            none is tested. None if the loop was stated.
    """

    found: bool
    probability: float | None

    @property
    def verdict(self) -> str:
        """Result in words; a test cannot exclude feedback."""
        if self.probability is None:
            return "closed loop, as stated" if self.found else "open loop, as stated"
        return "feedback found" if self.found else "feedback not excluded"

    def to_dict(self) -> dict[str, object]:
        """Content for fit.json."""
        return {"verdict": self.verdict, "probability": self.probability}


def _lagged(series: Vector, first: int, last: int) -> Matrix:
    """Values `first` to `last` samples before each sample from `MEMORY` on, (n - MEMORY, lags)."""
    count = len(series)
    return np.column_stack([series[MEMORY - k : count - k] for k in range(first, last + 1)])


def _remainder(target: Vector, rows: Matrix) -> Vector:
    return target - rows @ np.linalg.lstsq(rows, target, rcond=1e-10)[0]


def _clipped(series: Vector) -> Vector:
    """Series without its mean, limited to `CLIP` robust standard deviations."""
    centred = series - np.median(series)
    level = NORMAL_MAD * float(np.median(np.abs(centred)))
    return np.clip(centred, -CLIP * level, CLIP * level) if level > 0.0 else 0.0 * centred


def _held(speed: Vector) -> Vector:
    """Speed with the last value in place of missing ones: it must not know later speeds."""
    present = np.isfinite(speed)
    latest = np.maximum.accumulate(np.where(present, np.arange(len(speed)), 0))
    return np.nan_to_num(speed[latest])


def _share(answer: Vector, causes: Matrix) -> float:
    """Share of the power of a series that others explain."""
    power = float(answer @ answer)
    rest = _remainder(answer, causes)
    return 1.0 - float(rest @ rest) / power if power > 0.0 else 0.0


def _tested(record: Record) -> list[slice]:
    """Segments of a record, or pieces in equal distances of one with more than `MOST` samples."""
    total = sum(part.stop - part.start for part in record.segments)
    if total <= MOST:
        return list(record.segments)
    pieces = [
        slice(start, min(start + PIECE, part.stop))
        for part in record.segments
        for start in range(part.start, part.stop, PIECE)
    ]
    return [pieces[int(k)] for k in np.arange(0, len(pieces), total / MOST)]


def _record(record: Record) -> float | None:
    """Probability of the F test of a record, 1 if the shifts do not confirm it; None: no test."""
    commands = [c for c in (record.setpoint, record.reference) if c is not None]
    target, rows, measured, past = [], [], [], []
    for part in _tested(record):
        current, speed = record.current[part], _held(record.speed[part])
        if len(current) > 3 * MEMORY:
            known = [_lagged(current, 1, MEMORY), *(_lagged(c[part], 0, 2) for c in commands)]
            target.append(current[MEMORY:])
            rows.append(np.column_stack([np.ones(len(current) - MEMORY), *known]))
            measured.append(speed[MEMORY:])
            past.append(np.column_stack([rows[-1], _lagged(speed, 1, MEMORY)]))
    if sum(map(len, target)) < FEWEST:
        return None
    every = np.vstack(rows)
    answer = _remainder(np.concatenate(target), every)
    level = NORMAL_MAD * float(np.median(np.abs(answer)))
    # the speed knows the current before it was rounded, so that it predicts its rounding error
    if level <= max(PREDICTABLE * float(np.std(record.current)), quantum(record.current) or 0.0):
        return None
    white = _clipped(_remainder(np.concatenate(measured), np.vstack(past)))
    limited = _clipped(answer)
    # the levels of a programme of steps outlast its jumps, which are limited
    answer = _remainder(limited[MEMORY:], _lagged(limited, 1, MEMORY))
    same, earlier = white[MEMORY:], _lagged(white, 1, LAGS)
    freedom = len(answer) - every.shape[1] - MEMORY

    def probability(answer: Vector) -> float:
        later = _tail(_share(answer, earlier), LAGS, freedom - LAGS)
        # more current at a larger speed is no feedback, but a current that was recorded late
        opposed = float(answer @ same) < 0.0
        at_once = 0.5 * _tail(_share(answer, same[:, None]), 1, freedom - 1) if opposed else 1.0
        return min(1.0, 2.0 * min(later, at_once))

    least = probability(answer)
    if least > STRONG:
        return least
    as_strong = max(least, SURE)
    apart = max(len(answer) // (SHIFTS + 1), 1)
    smaller = 0
    for k in range(1, SHIFTS + 1):
        smaller += probability(np.roll(answer, k * apart)) <= as_strong
        if smaller > LEVEL * (SHIFTS + 1) - 1.0:
            return 1.0
    return least


def _tail(share: float, causes: int, freedom: int) -> float:
    """Probability of a larger share with no relation: of Beta(causes / 2, freedom / 2)."""
    return float(betainc(0.5 * freedom, 0.5 * causes, 1.0 - min(max(share, 0.0), 1.0)))


def feedback_in(records: Sequence[Record]) -> Feedback:
    """Test records for feedback.

    Without feedback, the current has no part in earlier disturbances: what its own past (and the
    commands of the record) do not predict is independent of earlier residuals of the speed. The
    share of this part that the residuals explain is tested (Granger 1969; Haugh 1976), and compared
    with that of shifted currents. A current holds from its sample on, so that the residual of the
    same sample is an earlier one; only a current against it counts as feedback.
    """
    tested = [p for record in records if (p := _record(record)) is not None]
    least = min(1.0, min(tested, default=1.0) * max(len(tested), 1))
    return Feedback(least < STRONG, least)
