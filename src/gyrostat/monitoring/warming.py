"""Viscous friction over temperature in a window, as an exponential.

The viscosity of a lubricant falls by a nearly constant share with each kelvin, so that the viscous
coefficient is b exp(-k t) at t kelvin above the mean temperature. A line through it is off by
k² t² / 2: with k = 0.045 1/K and an orbit of ±10 K, by a tenth. About a share k0 the columns are

    b |w| exp(-k0 t) + c |w| t exp(-k0 t),  c = -(k - k0) b

and k0 is found by Gauss-Newton steps.
"""

from dataclasses import replace

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.monitoring.estimate import quick_look
from gyrostat.monitoring.moments import VISCOUS, WARMING, Prior
from gyrostat.monitoring.noise import Noise
from gyrostat.monitoring.regression import Rows

STEPS = 4
"""Largest number of steps."""
MOST = 0.1
"""Largest share that is believed, 1/K."""
SMALL = 0.02
"""Change of the viscous coefficient at the ends of the window below which the steps end."""


def about_its_share(rows: Rows, prior: Prior, noise: Noise) -> tuple[Rows, Prior]:
    """Rows and prior about the share by which viscous friction falls with each kelvin.

    Args:
        rows: Rows about a share of 0.
        prior: What is known of the wheel beforehand.
        noise: Noise of the previous window.
    """
    if rows.regressors.shape[1] <= WARMING or not np.any(rows.regressors[:, WARMING]):
        return rows, prior
    warm = rows.regressors[:, WARMING] / rows.regressors[:, VISCOUS]
    reach, share, found = float(np.max(np.abs(warm))), 0.0, (rows, prior)
    for _ in range(STEPS):
        value = quick_look(*found, noise).value
        viscous = float(value[VISCOUS])
        if viscous <= 0.0:
            return rows, prior
        before, share = share, float(np.clip(share - value[WARMING] / viscous, -MOST, MOST))
        if abs(share - before) * reach < SMALL:
            break
        mean = prior.mean.copy()
        mean[WARMING] += share * viscous
        found = _about(rows, np.exp(-share * warm)), replace(prior, mean=mean)
    return found


def _about(rows: Rows, fallen: Vector) -> Rows:
    """Rows with viscous friction over that at the mean temperature, (N,)."""
    regressors, instruments = rows.regressors.copy(), rows.instruments.copy()
    for columns in (regressors, instruments):
        columns[:, [VISCOUS, WARMING]] *= fallen[:, None]
    return replace(rows, regressors=regressors, instruments=instruments)
