"""Moreira, Lopes and Kuga: friction torque of a wheel on bristles, by Kalman filter.

M. L. B. Moreira, R. V. F. Lopes and H. K. Kuga, "Estimation of torque in a reaction wheel using a
bristle model for friction".
"""

from gyrostat.papers.moreira_lopes_kuga.estimated import estimated, with_filter
from gyrostat.papers.moreira_lopes_kuga.printed import CITATION, NAME
from gyrostat.papers.moreira_lopes_kuga.with_model import with_model
from gyrostat.papers.reproduction import Paper, Part, Reproduction, Say

SEEDS, QUICK_SEEDS = 64, 40

SETTINGS = (
    "Parameters as printed; the exponent of (2) with its sign corrected; control by (15) and (16), "
    "h running on between measurements as the filter predicts.",
    "Wheel and filter start from zero; one measurement a second from 0 s.",
)


def reproduce(*, quick: bool, say: Say) -> Reproduction:
    """Rebuild the paper and judge each claim.

    Args:
        quick: fewer noise seeds.
        say: told about the progress.
    """
    seeds = QUICK_SEEDS if quick else SEEDS
    say(f"{NAME}: {seeds} runs with and without the filter")
    kalman = with_filter(seeds)
    paper = estimated(kalman, seeds)
    say(f"{NAME}: the filter that carries the friction model, wrong by 10 %")
    return Reproduction(
        paper=NAME,
        citation=CITATION,
        parts=(paper, with_model(kalman, seeds), Part(claims=(), settings=SETTINGS)),
        complete=not quick,
    )


MOREIRA_LOPES_KUGA = Paper(NAME, reproduce)

__all__ = ["MOREIRA_LOPES_KUGA"]
