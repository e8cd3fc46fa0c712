"""Carrara and Kuga: friction of a real reaction wheel, and its compensation on a table.

V. Carrara and H. K. Kuga, "Estimating friction parameters in reaction wheels for attitude control".
"""

from gyrostat.papers.carrara_kuga.crossing_zero import crossing_zero
from gyrostat.papers.carrara_kuga.goals import goals
from gyrostat.papers.carrara_kuga.printed import CITATION, NAME
from gyrostat.papers.carrara_kuga.recovery import recovery
from gyrostat.papers.carrara_kuga.residuals import residuals
from gyrostat.papers.carrara_kuga.single_wheel import single_wheel
from gyrostat.papers.carrara_kuga.stribeck_speed import stribeck_speed
from gyrostat.papers.carrara_kuga.table_of_parameters import table_of_parameters
from gyrostat.papers.carrara_kuga.virtual_bench import run_trials
from gyrostat.papers.reproduction import Paper, Part, Reproduction, Say

RECORDS, QUICK_RECORDS = 200, 12
"""Virtual records of profile 2, each with its profile 1."""
VARIED, QUICK_VARIED = 20, 4
"""Of these, records on which the Stribeck speed is varied."""

SETTINGS = (
    "The virtual wheel has the statistical column of Table 1, with T_s; deterministic means its "
    "other column, with T_s = c.",
    "Both profiles are sampled at 10 Hz, the current held between samples, white tachometer noise "
    "of 5 rpm.",
    "Profile 2: ten steps of 30 s, alternating in sign, of 0.06 to 0.15 A.",
    "Profile 1: 12.5 sine cycles of 0.08 to 0.20 A, each of a period within about 25 % of 24 s.",
    "A-priori sigmas of x2..x5 about the start (15): 5 rad/s²/A, 0.002 1/s, 0.3 and 0.6 rad/s²; "
    "the wheel starts from rest, which is known.",
    "The Stribeck speed is held at 4 rpm.",
)


def reproduce(*, quick: bool, say: Say) -> Reproduction:
    """Rebuild the paper and judge each claim.

    Args:
        quick: fewer records and noise seeds, no dispersed runs.
        say: told about the progress.
    """
    count, varied = (QUICK_RECORDS, QUICK_VARIED) if quick else (RECORDS, VARIED)
    say(f"{NAME}: Table 1, and what the model of the wheel implies")
    known: list[Part] = [table_of_parameters(), single_wheel()]
    say(f"{NAME}: {count} virtual records")
    trials = run_trials(count, say)
    return Reproduction(
        paper=NAME,
        citation=CITATION,
        parts=(
            *known,
            recovery(trials, say),
            stribeck_speed(trials[:varied], say),
            residuals(trials),
            Part(claims=(), settings=SETTINGS),
            crossing_zero(say, quick=quick),
            goals(say, quick=quick),
        ),
        complete=not quick,
    )


CARRARA_KUGA = Paper(NAME, reproduce)

__all__ = ["CARRARA_KUGA"]
