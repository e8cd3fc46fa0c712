"""Prediction of each record from all others, and of laws over temperature by it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.identification.pool.laws import Law, Polynomial
from gyrostat.identification.pool.posterior import Estimates, posterior
from gyrostat.identification.pool.usual import POLYNOMIAL

FEWEST = 3
"""Smallest number of records for held-out records: two predict the third."""


def held_out_scores(estimates: Estimates) -> tuple[Vector, float]:
    """Standard normal number of each estimate in its prediction, and the sum of log densities.

    Args:
        estimates: Estimates of n >= `FEWEST` records.

    Returns:
        Numbers, (n,), and the sum over all records.
    """
    scores, densities = [], []
    for k in range(len(estimates.values)):
        prediction = posterior(estimates.without(k)).prediction(
            estimates.temperature[k], estimates.date[k], estimates.errors[k]
        )
        scores.append(prediction.score(estimates.values[k]))
        densities.append(prediction.log_density(estimates.values[k]))
    return np.array(scores), float(np.sum(densities))


def log_scores(estimates: Estimates, reference: float) -> Mapping[str, float]:
    """Sum of log densities of held-out records for polynomials in temperature."""
    laws: dict[str, Sequence[Law]] = {
        "line": (Polynomial(reference, POLYNOMIAL[:1]),),
        "parabola": (Polynomial(reference, POLYNOMIAL),),
    }
    return {name: held_out_scores(replace(estimates, laws=law))[1] for name, law in laws.items()}
