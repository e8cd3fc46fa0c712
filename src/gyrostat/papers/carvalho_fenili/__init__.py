"""Carvalho and Fenili: LQR and SDRE attitude control while one or two of three wheels fail.

C. A. de Carvalho Junior and A. Fenili, "Nonlinear attitude control of artificial satellites
considering failure in momentum wheels".
"""

from gyrostat.papers.carvalho_fenili import exchange, judged, recoveries
from gyrostat.papers.carvalho_fenili.drawings import (
    case_drawing,
    exchange_drawing,
    frozen_drawing,
)
from gyrostat.papers.carvalho_fenili.exchange import exchange_claims, exchanged
from gyrostat.papers.carvalho_fenili.flights import continuous, held
from gyrostat.papers.carvalho_fenili.goals import goals
from gyrostat.papers.carvalho_fenili.laws import laws
from gyrostat.papers.carvalho_fenili.numbers import number_claims
from gyrostat.papers.carvalho_fenili.printed import CASES, CITATION, NAME
from gyrostat.papers.carvalho_fenili.recoveries import recovered, recovery_claims
from gyrostat.papers.carvalho_fenili.recovery_drawing import recovery_drawing
from gyrostat.papers.carvalho_fenili.sentences_lqr import sentences_lqr
from gyrostat.papers.carvalho_fenili.sentences_sdre import conclusion, sentences_sdre
from gyrostat.papers.reproduction import Paper, Part, Reproduction, Say

SETTINGS = (
    "Classical 3-1-3 angles with (5), (16), (17) and (18) corrected; both laws regulate theta - "
    "pi/2, since theta itself to zero would drive the body into the singularity.",
    "Runge-Kutta of fourth order at 0.01 s, the law evaluated at every stage; a torque is zero in "
    "every step that begins at 15 s or later, and the laws do not know of it.",
    "Angles are never reduced by whole turns. A run is valid while sin(theta) is 0.005 or more in "
    "all stages; values are those of the last valid sample.",
)


def reproduce(*, quick: bool, say: Say) -> Reproduction:
    """Rebuild the paper and judge each claim.

    Args:
        quick: leaves out the dispersed cases of the goals.
        say: told about the progress.
    """
    both = laws()._asdict()
    flights, sampled, wheels, after = {}, {}, {}, {}
    for law, function in both.items():
        say(f"{NAME}: {len(CASES)} cases by {law.upper()}, the law at every stage")
        flights[law] = continuous(function)
        say(f"{NAME}: the same, sampled and held")
        sampled[law] = held(function)
        say(f"{NAME}: the same on wheels")
        wheels[law] = exchanged(function)
        say(f"{NAME}: recovery after each failure")
        after[law] = recovered(function)
    parts = (
        Part(
            claims=number_claims(flights, sampled),
            drawings=(
                *(case_drawing(case, flights, sampled) for case in CASES),
                frozen_drawing(flights),
            ),
            settings=SETTINGS,
        ),
        Part(
            claims=(*sentences_lqr(flights["lqr"]), *sentences_sdre(flights), *conclusion(flights)),
            settings=judged.SETTINGS,
        ),
        Part(
            claims=exchange_claims(wheels),
            drawings=(exchange_drawing(flights, wheels),),
            settings=exchange.SETTINGS,
        ),
        Part(
            claims=recovery_claims(after),
            drawings=(recovery_drawing(after),),
            settings=recoveries.SETTINGS,
        ),
        goals(say, quick=quick),
    )
    return Reproduction(NAME, CITATION, parts, complete=not quick)


CARVALHO_FENILI = Paper(NAME, reproduce)

__all__ = ["CARVALHO_FENILI"]
