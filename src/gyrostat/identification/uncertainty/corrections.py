"""Effects that a record shows, as currents that are added to the recorded one.

The average over effects is linearised at a fit without them. A drift of 5 % of the friction shifts
zero crossings so far that this no longer holds: the static torque came out 7 % too large on
average. With the currents that act as the effects at their estimates, the fit is repeated, and the
average is linearised at the true motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.uncertainty.averaging import Effect
from gyrostat.identification.uncertainty.effects import Nuisance

SHOWN = 0.8
"""Probability of an effect above which the current is corrected: more than the prior one of 2/3,
which a record that shows nothing leaves as it is. At 0.95, constant torques of 0.85 to 0.94 were
left to the linearisation, and shifted the static torque by 20 to 35 %, 5 to 7 sigma."""


@dataclass(frozen=True)
class Correction:
    """Current that acts as an effect at its estimate.

    Attributes:
        name: Identifier of the effect.
        at: Coefficients, (m,), in the unit of the effect.
        sigma: Largest prior standard deviation of a coefficient.
        probability: Probability of the effect before it was corrected.
        currents: For each record the current to add at its samples, (N,), A.
    """

    name: str
    at: Vector
    sigma: float
    probability: float
    currents: tuple[Vector, ...]

    def change(self, before: "Correction | None") -> float:
        """Largest change of a coefficient, in prior standard deviations."""
        earlier = 0.0 if before is None else before.at
        return float(np.max(np.abs(self.at - earlier))) / self.sigma


def corrections(
    effects: Sequence[Nuisance], found: Sequence[Effect], coefficients: Vector
) -> tuple[Correction, ...]:
    """Corrections for all effects that the records show and that a current can stand for.

    Args:
        effects: Effects averaged over.
        found: Their posteriors, in the same order.
        coefficients: Mean coefficients of all of them about the linearisation, (m,).
    """
    made, first = [], 0
    for effect, posterior in zip(effects, found, strict=False):
        change = coefficients[first : first + effect.columns[0].shape[1]]
        first += len(change)
        if effect.currents is None:
            continue
        if effect.at is None and posterior.probability <= SHOWN:
            continue
        at = change if effect.at is None else effect.at + change
        currents = tuple(np.append(shape @ at, 0.0) for shape in effect.currents)
        sigma = max(effect.scales)
        made.append(Correction(effect.name, at, sigma, posterior.probability, currents))
    return tuple(made)
