"""Wheels that do not belong to the lot, with a stated rate of false alarms.

The candidate is the wheel with the least likely estimate; it is judged by the prediction for a new
wheel from all others, whose uncertainty is included. Then it is taken away and the next one is
judged, so that two outliers do not hide each other; all candidates up to the last significant one
are outliers (B. Rosner, 1983, Technometrics 25).
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from gyrostat.core.pictured import Described
from gyrostat.core.types import Vector
from gyrostat.identification.judge.fit_changes import FALSE_ALARMS
from gyrostat.identification.lot.likelihood import share_below
from gyrostat.identification.lot.posterior import LotDraws, lot_draws

MOST, SHARE = 5, 0.1
"""Largest number of outliers of a parameter, and largest share of the wheels."""
DRAWS = 512


@dataclass(frozen=True)
class Suspect(Described):
    """Wheel whose estimate does not belong to the lot.

    Attributes:
        wheel: Index of the wheel.
        chance: Probability of so unlikely an estimate of any wheel and parameter of the lot.
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
    rest = np.arange(len(values))
    candidates: list[Suspect] = []
    for _ in range(min(MOST, int(SHARE * len(values)))):
        draws = lot_draws(values[rest], errors[rest], shape, DRAWS)
        place = int(np.argmax(np.abs(scores(values[rest], errors[rest], draws))))
        wheel, rest = int(rest[place]), np.delete(rest, place)
        others = lot_draws(values[rest], errors[rest], shape, DRAWS)
        below = float(others.weight @ share_below(values[wheel], errors[wheel], *others.lots.T))
        chance = 2.0 * min(below, 1.0 - below) * (len(rest) + 1) * parameters
        candidates.append(Suspect(wheel, min(chance, 1.0)))
    alarms = [k for k, suspect in enumerate(candidates) if suspect.chance <= FALSE_ALARMS]
    return candidates[: alarms[-1] + 1] if alarms else []
