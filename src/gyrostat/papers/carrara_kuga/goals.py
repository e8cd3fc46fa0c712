"""The claims of the dispersed runs."""

from collections.abc import Callable

import numpy as np

from gyrostat.papers.carrara_kuga.dispersed import (
    CONTENDERS,
    GOAL,
    RUNS,
    SETTINGS,
    Contender,
    Outcome,
    evaluate,
)
from gyrostat.papers.carrara_kuga.side_by_side import side_by_side
from gyrostat.papers.carrara_kuga.table_drawings import peaks_drawing
from gyrostat.papers.claims import Claim
from gyrostat.papers.reproduction import Part, Say

Read = Callable[[Outcome], float]

CASES = {
    "white": "5 rpm white tachometer noise",
    "hall": "24-pulse tachometer counted over 0.1 s",
    "step30": "friction 30 % larger or smaller after the crossing, the worse",
    "lugre": "bristles that bend by 0.1 rad before they slip",
}


def _ninety_five(values: np.ndarray) -> float:
    return float(np.percentile(values, 95.0))


# id -> quantity, unit, goal for the compensator, how to read it
QUANTITIES: dict[str, tuple[str, str, float | None, Read]] = {
    "peak95_white_deg": (
        f"attitude peak, 95 % of runs, {CASES['white']}",
        "deg",
        GOAL,
        lambda o: _ninety_five(o.peaks["white"]),
    ),
    "peak_max_white_deg": (
        f"attitude peak, largest of all runs, {CASES['white']}",
        "deg",
        0.05,
        lambda o: float(np.max(o.peaks["white"])),
    ),
    "peak95_hall_deg": (
        f"attitude peak, 95 % of runs, {CASES['hall']}",
        "deg",
        GOAL,
        lambda o: _ninety_five(o.peaks["hall"]),
    ),
    "peak_max_hall_deg": (
        f"attitude peak, largest of all runs, {CASES['hall']}",
        "deg",
        0.05,
        lambda o: float(np.max(o.peaks["hall"])),
    ),
    "peak95_step30_deg": (
        f"attitude peak, 95 % of runs, {CASES['step30']}",
        "deg",
        0.06,
        lambda o: _ninety_five(o.peaks["step30"]),
    ),
    "peak95_lugre_deg": (
        f"attitude peak, 95 % of runs, {CASES['lugre']}",
        "deg",
        0.06,
        lambda o: _ninety_five(o.peaks["lugre"]),
    ),
    "true_peak95_white_deg": (
        f"peak of the true attitude, 95 % of runs, {CASES['white']}",
        "deg",
        None,
        lambda o: _ninety_five(o.true_peaks["white"]),
    ),
    "true_peak95_hall_deg": (
        f"peak of the true attitude, 95 % of runs, {CASES['hall']}",
        "deg",
        None,
        lambda o: _ninety_five(o.true_peaks["hall"]),
    ),
    "chatter95_A": (
        "rms chatter of the current, 95 % of runs, the worse of white and Hall",
        "A",
        0.010,
        lambda o: max(map(_ninety_five, o.chatter)),
    ),
    "sign_changes95_per_s": (
        "sign changes of the current, 95 % of runs, the worse of white and Hall",
        "1/s",
        0.3,
        lambda o: max(map(_ninety_five, o.changes)),
    ),
    "hunt_deg": (
        "largest deviation from the mean attitude at rest, all runs, c and T_s 10 % too large",
        "deg",
        0.02,
        lambda o: float(np.max(o.hunting)),
    ),
}


def goals(say: Say, *, quick: bool) -> Part:
    """Fly every controller through the dispersed runs; when `quick`, only once for the figure."""
    together = side_by_side()
    if quick:
        return Part(
            drawings=(together,),
            claims=tuple(claim for c in CONTENDERS for claim in _not_computed(c)),
        )
    outcomes = {}
    for contender in CONTENDERS:
        say(f"carrara-kuga: {RUNS} dispersed runs in each case, {contender.name}")
        outcomes[contender] = evaluate(contender, RUNS)
    peaks = {CASES[case]: {c.name: o.peaks[case] for c, o in outcomes.items()} for case in CASES}
    wanted = {what: QUANTITIES[f"peak95_{case}_deg"][2] or 0.0 for case, what in CASES.items()}
    colours = {c.name: c.colour for c in CONTENDERS}
    return Part(
        claims=tuple(claim for c, o in outcomes.items() for claim in _claims(c, o)),
        drawings=(together, peaks_drawing(peaks, colours, wanted)),
        settings=SETTINGS,
    )


def _claims(contender: Contender, outcome: Outcome) -> list[Claim]:
    ours = contender is CONTENDERS[0]
    incomplete = f" {outcome.incomplete} runs did not complete." if outcome.incomplete else ""
    claims = []
    for name, (quantity, unit, goal, read) in QUANTITIES.items():
        value = read(outcome)
        why = "Beside the estimating compensator, in the same runs."
        if ours and goal is not None:
            reached = "reached" if value <= goal else "missed"
            why = f"The goal set beforehand is at most {goal:g} {unit}: {reached}."
        elif ours:
            why = "The gyro's own drift is in it, which no controller can see."
        claims.append(
            Claim(
                id=f"{contender.key}.{name}",
                quantity=f"{contender.name}: {quantity}",
                ours=value,
                unit=unit,
                why=why + incomplete,
            )
        )
    return claims


def _not_computed(contender: Contender) -> list[Claim]:
    return [
        Claim(
            id=f"{contender.key}.{name}",
            quantity=f"{contender.name}: {quantity}",
            ours=None,
            unit=unit,
            why="Not computed: dispersed runs belong to the full reproduction.",
        )
        for name, (quantity, unit, _, _) in QUANTITIES.items()
    ]
