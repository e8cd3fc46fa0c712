"""Our own requirements on recoveries, for dispersed cases."""

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.papers.carvalho_fenili.with_momentum import PRINCIPAL, full_beside_reduced, ratios
from gyrostat.papers.carvalho_fenili.without_momentum import REQUIREMENTS, times
from gyrostat.papers.claims import Value
from gyrostat.papers.reproduction import Part, Run

WITH_MOMENTUM, WITHOUT, SIDE_BY_SIDE = 400, 300, 8
"""Number of cases in each set."""
ERRORS = {"": 0.0, "_5pct": 0.05}
"""Suffix of the ids -> relative error of the inertia."""


def every_set(run: Run) -> Part:
    """Simulate every set and count the cases that meet the requirement."""
    parts = [
        counted(
            f"goals.momentum_{shape}{suffix}",
            ratios(shape, error, WITH_MOMENTUM, run.say),
            1.0,
            "worst_ratio",
        )
        for shape in PRINCIPAL
        for suffix, error in ERRORS.items()
    ]
    for requirement in REQUIREMENTS:
        settling = times(requirement, WITHOUT, run.say)
        parts.append(counted(f"goals.{requirement.key}", settling, requirement.allowed, "worst_s"))
    run.say(f"{SIDE_BY_SIDE} cases on the full gyrostat and on the reduced one")
    difference, change = full_beside_reduced(SIDE_BY_SIDE)
    values: dict[str, Value] = {
        "goals.full_beside_reduced_s": difference if np.isfinite(difference) else None,
        "goals.momentum_change": change,
    }
    counts: dict[str, str] = {}
    for set_values, text in parts:
        values |= set_values
        counts |= text
    return Part(values, {"counts": counts})


def counted(
    prefix: str, found: Vector, allowed: float, worst: str
) -> tuple[dict[str, Value], dict[str, str]]:
    """Values of one set, and the counts behind them by its prefix without "goals.".

    Args:
        prefix: Prefix of the ids.
        found: Settling times, or their ratios to the allowed time; infinite if a case does not
            settle.
        allowed: Largest value that is in time.
        worst: End of the id of the largest value.
    """
    inside, settled = int(np.sum(found <= allowed)), int(np.sum(np.isfinite(found)))
    values: dict[str, Value] = {
        f"{prefix}_share": inside / len(found),
        f"{prefix}_{worst}": float(np.max(found)) if settled == len(found) else None,
    }
    text = f"{inside} of {len(found)} settle in time, {settled} at all."
    return values, {prefix.removeprefix("goals."): text}
