"""The goals set beforehand for recoveries, over dispersed cases."""

import numpy as np

from gyrostat._types import Vector
from gyrostat.papers.carvalho_fenili.goals_momentum import (
    PRINCIPAL,
    full_beside_reduced,
    ratios,
)
from gyrostat.papers.carvalho_fenili.goals_zero import GOALS, Goal, times
from gyrostat.papers.carvalho_fenili.printed import NAME
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part, Say

WITH_MOMENTUM, WITHOUT, SIDE_BY_SIDE = 400, 300, 8
"""Cases of each set."""
ERRORS = {"": 0.0, "_5pct": 0.05}
"""Of the inertia, in ids -> share."""
CLOSEST, CONSERVED = 0.5, 1e-8
"""s, and relative."""
NOT_COMPUTED = "Not computed: dispersed runs belong to the full reproduction."
SETTINGS = (
    f"With momentum: {WITH_MOMENTUM} cases in each set, wheels of 0.1 N·m and 3 N·m·s along three "
    "axes, one failed, 0.1 to 2.9 N·m·s across its axis, random attitudes and targets that can be "
    "held, at rest, drifting or tumbling at first; settled within 0.05 deg for good. Allowed: "
    "100 s + 15 J / rho with the largest inertia J and rho across the failed axis.",
    f"Next to no momentum: {WITHOUT} cases in each set, the failed wheel seized, the target as "
    "near to a random attitude as can be held; settled within 0.05 deg and 1e-4 rad/s for good. "
    "Half of the bodies are cubes of 12 kg·m², half have 8, 12 and 16 kg·m² about random axes.",
)


def goals(say: Say, *, quick: bool) -> Part:
    """Fly every set and count; when `quick`, say that it was not done."""

    def tell(text: str) -> None:
        say(f"{NAME}: {text}")

    found: list[tuple[Claim, ...]] = []
    for shape in PRINCIPAL:
        for suffix, error in ERRORS.items():
            shares = None if quick else ratios(shape, error, WITH_MOMENTUM, tell)
            found.append(with_momentum(shape, suffix, error, shares))
    for goal in GOALS:
        found.append(without_momentum(goal, None if quick else times(goal, WITHOUT, tell)))
    found.append(_side_by_side(quick=quick, say=tell))
    return Part(claims=tuple(claim for claims in found for claim in claims), settings=SETTINGS)


def with_momentum(
    shape: str, suffix: str, error: float, shares: Vector | None
) -> tuple[Claim, ...]:
    """Claims of a set with momentum.

    Args:
        shape: of the body.
        suffix: of the id.
        error: of the inertia.
        shares: settling times over the times allowed; None where they were not computed.
    """
    known = f"inertia {error:.0%} wrong" if error else "inertia known"
    of = f"two wheels and momentum, {shape}, {known}"
    return _counted(
        f"goals.momentum_{shape}{suffix}",
        of,
        shares,
        1.0,
        ("worst_ratio", f"longest settling time over the time allowed, {of}", ""),
    )


def without_momentum(goal: Goal, settled: Vector | None) -> tuple[Claim, ...]:
    """Claims of a set with next to no momentum, from its settling times, s, or None."""
    of = f"two wheels, {goal.name}"
    worst = ("worst_s", f"longest settling time, {of}", "s")
    return _counted(f"goals.{goal.key}", of, settled, goal.allowed, worst, stretch=goal.stretch)


def _counted(
    prefix: str,
    of: str,
    found: Vector | None,
    allowed: float,
    worst: tuple[str, str, str],
    *,
    stretch: bool = False,
) -> tuple[Claim, ...]:
    key, quantity, unit = worst
    what = f"share of the cases that settle in time, {of}"
    if found is None:
        return (
            Claim(f"{prefix}_share", what, None, "", NOT_COMPUTED),
            Claim(f"{prefix}_{key}", quantity, None, unit, NOT_COMPUTED),
        )
    inside = int(np.sum(found <= allowed))
    every = inside == len(found)
    goal = "No goal was set; in time means" if stretch else "The goal set beforehand is all"
    verdict = "" if stretch else f": {'reached' if every else 'missed'}"
    limit = f" within {allowed:g} s" if unit else " within the time allowed"
    why = f"{inside} of {len(found)}. {goal}{limit}{verdict}."
    last = float(np.max(found))
    settled = f"{int(np.sum(np.isfinite(found)))} of {len(found)} settle."
    return (
        Claim(f"{prefix}_share", what, inside / len(found), "", why),
        Claim(f"{prefix}_{key}", quantity, last if np.isfinite(last) else None, unit, settled),
    )


def _side_by_side(*, quick: bool, say: Say) -> tuple[Claim, Claim]:
    apart = "goals.full_beside_reduced_s", "largest difference of settling times, full and reduced"
    change = "goals.momentum_change", "largest relative change of the total momentum, full gyrostat"
    if quick:
        return Claim(*apart, None, "s", NOT_COMPUTED), Claim(*change, None, "", NOT_COMPUTED)
    say(f"{SIDE_BY_SIDE} cases on the full gyrostat and on the reduced one")
    found = full_beside_reduced(SIDE_BY_SIDE)
    most = float(np.max(found.apart))
    return (
        Claim(
            *apart,
            most if np.isfinite(most) else None,
            "s",
            f"{SIDE_BY_SIDE} cases with momentum. {_judged(most, CLOSEST)}",
        ),
        Claim(
            *change,
            found.change,
            "",
            f"Made anew from attitude, rate and wheels. {_judged(found.change, CONSERVED)}",
        ),
    )


def _judged(value: float, most: float) -> str:
    verdict = "reached" if value <= most else "missed"
    return f"The goal set beforehand is at most {most:g}: {verdict}."
