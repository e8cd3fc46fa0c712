"""The same experiment from other starts: does the tuning survive what a fixed gain survives?"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.papers.claims import Claim
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Case, Flight
from gyrostat.papers.endo_sekiguchi_nonaka.printed import DURATION, REQUIRED

IN_TIME = 9000.0
"""s: a run holds if its error is below 0.05 degrees for good from here on."""
TORQUE_LIMIT = 0.1
"""N·m."""
EVERY = 100
"""Samples from one drawn point to the next."""
TURNS = (45, 90, 135, 180, 225, 270, 315)
"""Degrees added to the phases of the momentum."""
AXES = {
    "1_2_m3": (1.0, 2.0, -3.0),
    "2_1_3": (2.0, 1.0, 3.0),
    "m1_2_3": (-1.0, 2.0, 3.0),
    "1_m2_3": (1.0, -2.0, 3.0),
    "3_2_1": (3.0, 2.0, 1.0),
    "1_0_0": (1.0, 0.0, 0.0),
    "0_1_0": (0.0, 1.0, 0.0),
}
CASES: dict[str, Case] = {
    **{
        f"phase_{turn}deg": Case(f"momentum {turn}° later", shift=float(np.deg2rad(turn)))
        for turn in TURNS
    },
    **{
        f"axis_{key}": Case(f"axis ({axis[0]:g}, {axis[1]:g}, {axis[2]:g})", axis=axis)
        for key, axis in AXES.items()
    },
    "torque_limit_0p1": Case("0.1 N·m from rest", torque_limit=TORQUE_LIMIT),
}
SETTINGS = (
    f"Fragility: {len(TURNS)} other phases of the momentum (all components alike), {len(AXES)} "
    f"other initial axes, and wheels at rest with {TORQUE_LIMIT:g} N·m, one change at a time. A "
    f"run holds if its error is below {REQUIRED:g} degrees for good from {IN_TIME:g} s on. "
    "Where the gain runs away the motion is chaotic: figures of such a run change with the last "
    "digit of the arithmetic, what is said of it does not.",
)


@dataclass(frozen=True)
class Outcome:
    """What is kept of a run.

    Attributes:
        time: (N,) s, every ten seconds.
        error: (N,) of pointing, degrees; NaN once it has diverged.
        worst: largest error from 7000 s on, as far as it is valid; the last valid one where it is
            not valid so long. Degrees.
        settled: from when on below 0.05 degrees for good, s; None where never.
        top_speed: largest commanded wheel speed, rad/s.
        valid_until: s.
    """

    time: np.ndarray
    error: np.ndarray
    worst: float
    settled: float | None
    top_speed: float
    valid_until: float

    @classmethod
    def of(cls, flight: Flight) -> "Outcome":
        """Keep a run."""
        judged = flight.judged[np.isfinite(flight.judged)]
        valid = flight.error[np.isfinite(flight.error)]
        return cls(
            time=flight.time[::EVERY],
            error=np.array(flight.error[::EVERY]),
            worst=float(np.max(judged)) if len(judged) else float(valid[-1]),
            settled=flight.settled,
            top_speed=flight.top_speed,
            valid_until=flight.valid_until,
        )

    @property
    def holds(self) -> bool:
        """Whether it settled in time."""
        return self.settled is not None and self.settled <= IN_TIME

    def told(self) -> str:
        """One sentence."""
        when = (
            "It never settles below 0.05 degrees"
            if self.settled is None
            else f"It settles below 0.05 degrees at {self.settled:.1f} s"
        )
        end = "" if self.valid_until >= DURATION else f"; it diverges at {self.valid_until:.1f} s"
        return f"{when}{end}; wheels commanded up to {self.top_speed:.4g} rad/s."


LABELS = {"mec_frit": "MEC with FRIT", "fixed_gain_0p1": "MEC with K = 0.1"}


def fragility_claims(outcomes: Mapping[str, Sequence[Outcome]]) -> tuple[Claim, ...]:
    """Judge the dispersed runs.

    Args:
        outcomes: of each of `LABELS`, in the order of `CASES`.
    """
    claims = [
        Claim(
            "fragility.cases",
            "other starts",
            float(len(CASES)),
            "",
            "Other phases, other axes, a torque limit; the paper shows one start.",
        )
    ]
    for key, label in LABELS.items():
        held = [name for name, one in zip(CASES, outcomes[key], strict=True) if one.holds]
        claims.append(
            Claim(
                f"fragility.{key}_holds",
                f"of them, those in which {label} holds 0.05 degrees",
                float(len(held)),
                "",
                f"Held: {', '.join(held) or 'none'}.",
            )
        )
    for key, label in LABELS.items():
        claims += [
            Claim(
                f"fragility.{key}.{name}.max_deg",
                f"largest pointing error from 7000 s on, or the last before it diverged, {label}, "
                f"{case.name}",
                one.worst,
                "deg",
                one.told(),
            )
            for (name, case), one in zip(CASES.items(), outcomes[key], strict=True)
        ]
    return tuple(claims)
