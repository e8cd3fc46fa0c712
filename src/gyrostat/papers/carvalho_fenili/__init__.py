"""Carvalho and Fenili: LQR and SDRE attitude control while one or two of three wheels fail.

C. A. de Carvalho Junior and A. Fenili, "Nonlinear attitude control of artificial satellites
considering failure in momentum wheels".
"""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import NamedTuple

from gyrostat.papers.carvalho_fenili import exchange, judged, recoveries
from gyrostat.papers.carvalho_fenili.drawings import (
    case_drawing,
    exchange_drawing,
    frozen_drawing,
)
from gyrostat.papers.carvalho_fenili.exchange import (
    Exchange,
    exchange_claims,
    exchanged,
    flown_on_wheels,
)
from gyrostat.papers.carvalho_fenili.flights import continuous, held
from gyrostat.papers.carvalho_fenili.goals import goals
from gyrostat.papers.carvalho_fenili.laws import laws
from gyrostat.papers.carvalho_fenili.numbers import Flights, number_claims
from gyrostat.papers.carvalho_fenili.printed import CASES, CITATION, NAME
from gyrostat.papers.carvalho_fenili.recoveries import Recovered, recovered, recovery_claims
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


class Flown(NamedTuple):
    """Every flight, by law.

    Attributes:
        flights: the law at every stage of a step.
        sampled: the law sampled and held.
        wheels: on wheels.
        recoveries: from each failure on wheels.
    """

    flights: Flights
    sampled: Flights
    wheels: Mapping[str, Mapping[str, Exchange]]
    recoveries: Mapping[str, Recovered]


def fly(say: Say) -> Flown:
    """Fly all cases.

    Args:
        say: told about the progress.
    """
    both = laws()._asdict()
    sampled, wheels, after = {}, {}, {}
    with ThreadPoolExecutor() as beside:
        say(f"{NAME}: {len(CASES)} cases by each law, evaluated at every stage")
        flights = {law: beside.submit(continuous, function) for law, function in both.items()}
        for law, function in both.items():
            say(f"{NAME}: the same by {law.upper()}, sampled and held")
            sampled[law] = held(function)
            say(f"{NAME}: the same by {law.upper()} on wheels")
            on_wheels = flown_on_wheels(function)
            wheels[law] = exchanged(on_wheels)
            say(f"{NAME}: recovery after each failure under {law.upper()}")
            after[law] = recovered(on_wheels)
        return Flown({law: run.result() for law, run in flights.items()}, sampled, wheels, after)


def judge(flown: Flown) -> tuple[Part, ...]:
    """Judge each claim of the paper, and what was flown beside it."""
    flights, sampled, wheels, after = flown
    return (
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
    )


def reproduce(*, quick: bool, say: Say) -> Reproduction:
    """Rebuild the paper and judge each claim.

    Args:
        quick: leaves out the dispersed cases of the goals.
        say: told about the progress.
    """
    parts = (*judge(fly(say)), goals(say, quick=quick))
    return Reproduction(NAME, CITATION, parts, complete=not quick)


CARVALHO_FENILI = Paper(NAME, reproduce)

__all__ = ["CARVALHO_FENILI"]
