"""Whether a record shows the Stribeck speed, and what a wrong one does to the rest."""

from collections.abc import Sequence

import numpy as np

from gyrostat._types import Matrix
from gyrostat.papers.carrara_kuga.printed import NAMES, STRIBECK_SPEED
from gyrostat.papers.carrara_kuga.virtual_bench import Trial, estimate
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part, Say

FACTORS = (0.5, 2.0)
"""By which the held Stribeck speed is wrong."""
GOOD = 0.5
"""Of its value: an estimate is good when its sigma is below this."""
BARELY = 0.5
"""Standard deviations: a shift below this counts as barely affected."""


def stribeck_speed(trials: Sequence[Trial], say: Say) -> Part:
    """Estimate the Stribeck speed too, then hold it at half and at twice its value.

    Args:
        trials: whose records are used again.
        say: told what comes next.
    """
    say(f"the Stribeck speed free, halved and doubled on {len(trials)} records")
    return Part(claims=(*_freed(trials), *_misheld(trials)))


def _freed(trials: Sequence[Trial]) -> list[Claim]:
    fits = [estimate(trial.profile2.record, stribeck_speed=None) for trial in trials]
    places = [fit.names.index("stribeck_speed") for fit in fits]
    relative = [float(f.sigma[k] / f.values[k]) for f, k in zip(fits, places, strict=True)]
    values = [float(f.values[k]) / STRIBECK_SPEED for f, k in zip(fits, places, strict=True)]
    seen = sum(fit.observability["stribeck_speed"].observable for fit in fits)
    return [
        Claim(
            id="stribeck_speed.not_observable",
            quantity="the noise does not allow a good estimate of the Stribeck speed",
            paper=True,
            ours=float(np.median(relative)) > GOOD,
            unit="",
            tolerance=0.0,
            why=f"Estimated with the other four it exceeds 2 sigma on {seen} of {len(fits)} "
            f"records; good means a median sigma below {GOOD:g} of its value.",
        ),
        Claim(
            id="stribeck_speed.relative_sigma",
            quantity="formal sigma of an estimated Stribeck speed over its estimate, median",
            ours=float(np.median(relative)),
            unit="",
            why=f"From {len(fits)} virtual records; the estimates reach from {min(values):.2g} to "
            f"{max(values):.2g} times the truth.",
        ),
    ]


def _shifts(trial: Trial) -> Matrix:
    """Shift of each parameter in its standard deviations, (len(FACTORS), 4), without sign."""
    sigma = np.sqrt(np.diag(trial.covariance))
    base = np.array([trial.fit.parameters[n] for n in NAMES])
    rows = []
    for factor in FACTORS:
        fit = estimate(trial.profile2.record, stribeck_speed=factor * STRIBECK_SPEED)
        rows.append(np.abs(np.array([fit.parameters[n] for n in NAMES]) - base) / sigma)
    return np.array(rows)


def _misheld(trials: Sequence[Trial]) -> list[Claim]:
    largest = np.max([_shifts(trial) for trial in trials], axis=(0, 1))
    others, static = float(largest[:3].max()), float(largest[3])
    where = f"over {len(trials)} records, where barely means below {BARELY:g} sigma"
    return [
        Claim(
            id="stribeck_speed.barely_affects_motor_viscous_coulomb",
            quantity="k_m, b and c are barely affected by the held Stribeck speed",
            paper=True,
            ours=others < BARELY,
            unit="",
            tolerance=0.0,
            why=f"Held at half or twice its value it moves them by at most {others:.2g} sigma "
            f"{where}.",
        ),
        Claim(
            id="stribeck_speed.barely_affects_static",
            quantity="T_s, the remaining parameter, is barely affected by the held Stribeck speed",
            paper=True,
            ours=static < BARELY,
            unit="",
            tolerance=0.0,
            why=f"Held at half or twice its value it moves T_s by up to {static:.2g} sigma "
            f"{where}.",
        ),
    ]
