"""Endo, Sekiguchi and Nonaka: pointing with two wheels, a model error compensator tuned on line.

H. Endo, K. Sekiguchi and K. Nonaka, "Model error compensator for attitude control of 2-wheel
spacecraft with on-line FRIT based tuning".
"""

from gyrostat._jax import jnp
from gyrostat.papers.endo_sekiguchi_nonaka import fragility, sentences
from gyrostat.papers.endo_sekiguchi_nonaka.dispersed import dispersed_part
from gyrostat.papers.endo_sekiguchi_nonaka.drawings import (
    fragility_drawing,
    gain_drawing,
    input_drawing,
    output_drawing,
    pointing_drawing,
)
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Case, Flight, flown
from gyrostat.papers.endo_sekiguchi_nonaka.fragility import CASES, Outcome, fragility_claims
from gyrostat.papers.endo_sekiguchi_nonaka.numbers import GAINS, Flights, number_claims
from gyrostat.papers.endo_sekiguchi_nonaka.printed import (
    CITATION,
    FEEDBACK,
    NAME,
    NOMINAL,
    fixed,
    law,
    tuned,
)
from gyrostat.papers.endo_sekiguchi_nonaka.sentences import sentence_claims
from gyrostat.papers.reproduction import Paper, Part, Reproduction, Say

SETTINGS = (
    "(25) with its sign corrected. M = F/(s+F), sampled: m(k+1) = a m(k) + (1-a) x(k), a = "
    "exp(-F Ts), started at zero. Nominal output h_n(k+1) = h_n(k) + Ts F (r - h), from h(0): "
    "driven by the uncompensated input and the actual output. K made at a sample acts in the next.",
    "Plant: one Runge-Kutta step of fourth order in each period of 0.1 s, wheel speeds held; the "
    "wheels take a commanded speed at once. 10 000 s, one period of the momentum; errors are "
    "judged from 7000 s on. Sensors without error.",
    "The 0.5 % inertia error is that of J_tn. Each row of K waits while its own |h_n - h| is below "
    "the threshold.",
)
PLAIN = Case("own start")
COMPENSATED = {
    "ideal": (Case("ideal", total=NOMINAL, momentum=0.0), 0.0),
    "no_mec": (PLAIN, 0.0),
    **{name: (PLAIN, gain) for name, gain in GAINS.items()},
    "fixed_gain_1": (PLAIN, 1.0),
    "inertia_only": (Case("inertia", momentum=0.0), 0.0),
    "momentum_only": (Case("momentum", total=NOMINAL), 0.0),
}
"""Start and fixed gain of each run; the gain 0 is no compensator."""
TUNINGS = {
    "mec_frit": {},
    # F enters (25) alone
    "printed_sign": {"feedback": jnp.full(2, -FEEDBACK)},
    "from_output": {"filters_from_output": True},
}
"""Fields of the tuner that are not those of Table 3."""


def fly(say: Say) -> tuple[Flights, dict[str, list[Outcome]]]:
    """Fly the paper's own start and the others.

    Args:
        say: told about the progress.

    Returns:
        The runs of its own start; of the others what is kept of them, with FRIT and with K = 0.1.
    """
    others = list(CASES.values())
    say(f"{NAME}: {len(COMPENSATED)} runs of 10 000 s with fixed gains, {len(others)} other starts")
    cases = [case for case, _ in COMPENSATED.values()] + others
    gains = [gain for _, gain in COMPENSATED.values()] + [0.1] * len(others)
    own, steady = _kept(list(COMPENSATED), flown(cases, [fixed(gain) for gain in gains]))
    say(f"{NAME}: {len(TUNINGS)} runs with FRIT, {len(others)} other starts")
    cases = [PLAIN] * len(TUNINGS) + others
    changes = [*TUNINGS.values(), *({} for _ in others)]
    tuning, dispersed = _kept(list(TUNINGS), flown(cases, [tuned(**one) for one in changes]))
    say(f"{NAME}: the momentum computed from measurements")
    (known,) = flown([PLAIN], [law(momentum_measured=True)])
    flights = Flights(
        ideal=own["ideal"],
        no_mec=own["no_mec"],
        fixed={name: own[name] for name in (*GAINS, "fixed_gain_1")},
        **tuning,
        known_momentum=known,
        inertia_only=own["inertia_only"],
        momentum_only=own["momentum_only"],
    )
    return flights, {"mec_frit": dispersed, "fixed_gain_0p1": steady}


def _kept(names: list[str], flights) -> tuple[dict[str, Flight], list[Outcome]]:
    whole = {name: next(flights) for name in names}
    return whole, [Outcome.of(flight) for flight in flights]


def reproduce(*, quick: bool, say: Say) -> Reproduction:
    """Rebuild the paper and judge each claim.

    Args:
        quick: leaves the dispersed cases out; the rest is quick.
        say: told about the progress.
    """
    flights, outcomes = fly(say)
    parts = (
        Part(
            claims=number_claims(flights),
            drawings=(
                output_drawing(flights),
                pointing_drawing(flights),
                gain_drawing(flights),
                input_drawing(flights),
            ),
            settings=SETTINGS,
        ),
        Part(
            claims=sentence_claims(flights, outcomes["mec_frit"]),
            settings=sentences.SETTINGS,
        ),
        Part(
            claims=fragility_claims(outcomes),
            drawings=(fragility_drawing(outcomes),),
            settings=fragility.SETTINGS,
        ),
        dispersed_part(say, quick=quick),
    )
    return Reproduction(NAME, CITATION, parts, complete=not quick)


ENDO_SEKIGUCHI_NONAKA = Paper(NAME, reproduce)

__all__ = ["ENDO_SEKIGUCHI_NONAKA"]
