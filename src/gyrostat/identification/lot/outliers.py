"""Wheels that do not belong to the lot, with a stated rate of false alarms.

The candidates are the wheels whose estimates are least likely in the lot of the wheels nearest to
the median. Each is judged by the prediction for a new wheel from all others, whose uncertainty is
included, and then taken away, so that outliers do not hide each other; all candidates up to the
last significant one are outliers (B. Rosner, 1983, Technometrics 25).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.lot.likelihood import share_below
from gyrostat.identification.lot.posterior import LotDraws, lot_draws
from gyrostat.telemetry.signals import NORMAL_MAD

MOST, SHARE = 5, 0.2
"""Largest number of outliers of a parameter, and largest share of the wheels."""
DRAWS = 512


@dataclass(frozen=True)
class Suspect(Described):
    """Wheel whose estimate does not belong to the lot.

    Attributes:
        wheel: Index of the wheel.
        chance: Probability of so unlikely an estimate of any wheel and parameter of the lot, when
            the outliers named before it, or also some of those after it, are taken away.
    """

    wheel: int
    chance: float


def scores(values: Vector, errors: Vector, draws: LotDraws) -> Vector:
    """Standard normal number of each estimate in the lot of the medians of the draws, (n,)."""
    share = share_below(values, errors, *draws.typical())
    return ndtri(np.clip(share, 1e-300, 1.0 - 1e-16))


def outliers(values: Vector, errors: Vector, shape: str, parameters: int) -> list[Suspect]:
    """Wheels that do not belong to the lot.

    Args:
        values: Estimates, (n,).
        errors: Standard deviations of their errors, (n,).
        shape: Shape of the lot, see `gyrostat.identification.lot.posterior`.
        parameters: Number of parameters that are judged, which share the false alarms.
    """
    count = min(MOST, int(SHARE * len(values)))
    away = np.abs(values - np.median(values))
    spread = np.hypot(NORMAL_MAD * np.median(away), errors)
    core = np.argsort(away / spread, kind="stable")[: len(values) - count]
    draws = lot_draws(values[core], errors[core], shape, DRAWS)
    least_likely = np.abs(scores(values, errors, draws))
    rest = np.arange(len(values))
    candidates: list[tuple[int, float]] = []
    for wheel in np.argsort(-least_likely, kind="stable")[:count].tolist():
        rest = rest[rest != wheel]
        others = lot_draws(values[rest], errors[rest], shape, DRAWS)
        below = float(others.weight @ share_below(values[wheel], errors[wheel], *others.lots.T))
        chance = 2.0 * min(below, 1.0 - below) * (len(rest) + 1) * parameters
        candidates.append((wheel, min(chance, 1.0)))
    while candidates and candidates[-1][1] > FALSE_ALARMS:
        candidates.pop()
    # an outlier among others is as likely as with those after it away
    chances = np.minimum.accumulate([chance for _, chance in candidates[::-1]])[::-1]
    wheels = [wheel for wheel, _ in candidates]
    return [Suspect(*each) for each in zip(wheels, chances.tolist(), strict=True)]
