"""The claims of the dispersed cases."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.papers.claims import Claim
from gyrostat.papers.endo_sekiguchi_nonaka.contenders import (
    OURS,
    SAFE_FRIT,
    SLOW,
    UNCOMPENSATED,
    Contender,
    Outcome,
    evaluate,
)
from gyrostat.papers.endo_sekiguchi_nonaka.dispersed_drawing import dispersed_drawing
from gyrostat.papers.endo_sekiguchi_nonaka.dispersion import Case, dispersed, paper_case
from gyrostat.papers.endo_sekiguchi_nonaka.printed import NAME, REQUIRED
from gyrostat.papers.reproduction import Part, Say

CASES, SEED = 1000, 2024
"""Cases, which every controller flies, and their seed."""
GOALS = {"1p10": 1.10, "1p05": 1.05}
EXTRA = 40.0
"""s: a run is in time within 1.10 T + 40 s."""
SETTINGS = (
    f"Dispersed cases: {CASES}, seed {SEED}; pointing error 1..150 deg about any axis, |H0| up to "
    "0.2 N·m·s, any direction and phases, 1e-4 or 1e-3 Hz; inertia ±5 %, products 2 %, wheel axes "
    "0.5 deg off; wheels of 0.1 N·m and 30 N·m·s at -5, 0 or 5 rad/s, Coulomb friction 0.9e-3 N·m; "
    "the body rate follows from H0.",
    "Sensors at 10 Hz: star tracker 10 arcsec about each axis, gyro 5e-6 rad/s with a bias of 1 "
    "deg/h about each axis, tachometer 2e-3 rad/s. Every controller is given the attitude of the "
    "same filter.",
    "Wheels are driven by a speed loop (PI, 20 Hz, 2 rad/s, set-point led evenly from command to "
    "command) that reads its own wheel without noise; torque demand is what it asks for before "
    "the limit.",
    "The paper's three controllers fly for 15 000 s, judged in the last 5000 s, the others for "
    "6000 s, judged in the last 4000 s. In many cases a run of the paper's tuning is chaotic: "
    "rounding decides how it ends, and a case may end otherwise on another machine; the share of "
    "cases held stays within some two hundredths.",
)


@dataclass(frozen=True)
class Runs:
    """The dispersed cases flown.

    Attributes:
        cases: all of them.
        ours: all of them.
        others: key of a contender -> its runs of all of them.
        paper: our controller in the paper's own case.
    """

    cases: Sequence[Case]
    ours: Outcome
    others: Mapping[str, Outcome]
    paper: Outcome

    @property
    def quickest(self) -> np.ndarray:
        """T of each case, s."""
        return np.array([case.quickest for case in self.cases])


def fly_dispersed(say: Say, cases: int = CASES) -> Runs:
    """Fly the dispersed cases.

    Args:
        say: told about the progress.
        cases: how many.
    """
    drawn = dispersed(cases, SEED)

    def flown(contender: Contender, flights: Sequence[Case]) -> Outcome:
        def on_progress(done: int, total: int) -> None:
            say(f"{NAME}: {contender.name}, {done} of {total} runs of {contender.duration:g} s")

        return evaluate(contender, flights, on_progress=on_progress)

    ours = flown(OURS, [*drawn, paper_case()])
    others = {one.key: flown(one, drawn) for one in (SAFE_FRIT, UNCOMPENSATED, *SLOW)}
    return Runs(drawn, ours.part(slice(cases)), others, ours.part(slice(cases, None)))


def _ours(runs: Runs) -> list[Claim]:
    ours = runs.ours
    claims = [
        Claim(
            "dispersed.cases",
            "dispersed cases",
            float(len(runs.cases)),
            "",
            "Drawn at random from one seed.",
        ),
        Claim(
            "dispersed.success_fraction",
            f"cases that {OURS.name} holds below {REQUIRED:g} deg to the end",
            float(np.mean(ours.holds)),
            "",
            "The goal set beforehand is 1.",
        ),
        Claim(
            "dispersed.worst_settle_ratio",
            "settling time over the quickest there can be, T, largest",
            float(np.max(ours.settled / runs.quickest)),
            "",
            "The smallest turns have it: the start-up and the last tenth of a degree take as long "
            "after every turn.",
        ),
    ]
    claims += [
        Claim(
            f"dispersed.within_{key}_T_plus_40s_fraction",
            f"cases that are settled for good within {factor:g} T + {EXTRA:g} s",
            float(np.mean(ours.settled <= factor * runs.quickest + EXTRA)),
            "",
            "The goal set beforehand is 1."
            if key == "1p10"
            else "More than what was set as a goal beforehand.",
        )
        for key, factor in GOALS.items()
    ]
    for key, quantity, value, unit, why in (
        (
            "worst_last_error_deg",
            "largest error in the last 4000 s",
            float(np.max(ours.last)),
            "deg",
            "The goal set beforehand is at most 0.005.",
        ),
        (
            "worst_torque_demand_Nm",
            "largest torque demanded of a wheel",
            float(np.max(ours.demand)),
            "N·m",
            "The goal set beforehand is at most 0.105; the wheels give 0.1.",
        ),
        (
            "worst_roll_rate_deg_s",
            "largest rate about body z, which no wheel holds",
            float(np.rad2deg(np.max(ours.roll))),
            "deg/s",
            "It is bounded by momentum: what H0, products of inertia and tilted wheels leave.",
        ),
    ):
        claims.append(Claim(f"dispersed.{key}", f"{OURS.name}: {quantity}", value, unit, why))
    claims.append(
        Claim(
            "paper_case.settle_s",
            "paper's own case from rest with 0.1 N·m: settled for good",
            float(runs.paper.settled[0]),
            "s",
            "The goal set beforehand is at most 270 s; the paper's tuning takes some 6500 s "
            "without a torque limit, and never settles with one.",
        )
    )
    return claims


def _beside(runs: Runs) -> list[Claim]:
    claims = []
    for one in (*SLOW, SAFE_FRIT, UNCOMPENSATED):
        outcome = runs.others[one.key]
        claims.append(
            Claim(
                f"dispersed.{one.key}_success_fraction",
                f"cases that {one.name} holds below {REQUIRED:g} deg to the end",
                float(np.mean(outcome.holds)),
                "",
                f"Errors are judged from {one.duration - one.judged:g} s on.",
            )
        )
    for name, one, outcome in (
        ("ours", OURS, runs.ours),
        *((o.key, o, runs.others[o.key]) for o in (SAFE_FRIT, UNCOMPENSATED)),
    ):
        claims.append(
            Claim(
                f"dispersed.{name}_mean_last_error_deg",
                f"{one.name}: largest error in the last 4000 s, mean of cases",
                float(np.mean(outcome.last)),
                "deg",
                "Of the same cases: what the tuning, and what the compensator adds.",
            )
        )
    return claims


def dispersed_part(say: Say, *, quick: bool) -> Part:
    """Fly and judge the dispersed cases; when `quick`, say that they are not computed.

    Args:
        say: told about the progress.
        quick: leaves them out.
    """
    if quick:
        ids = {
            "dispersed.cases": "",
            "dispersed.success_fraction": "",
            "dispersed.worst_settle_ratio": "",
            "dispersed.worst_last_error_deg": "deg",
            **{f"dispersed.{one.key}_success_fraction": "" for one in SLOW},
            "paper_case.settle_s": "s",
        }
        why = "Not computed: dispersed runs belong to the full reproduction."
        return Part(
            claims=tuple(Claim(id, "dispersed cases", None, unit, why) for id, unit in ids.items())
        )
    runs = fly_dispersed(say)
    return Part(
        claims=(*_ours(runs), *_beside(runs)),
        drawings=(dispersed_drawing(runs.quickest, runs.ours, runs.others),),
        settings=SETTINGS,
    )
