"""The rules by which the sentences of section 6 are judged."""

import numpy as np

from gyrostat.papers.carvalho_fenili.flights import Flight
from gyrostat.papers.carvalho_fenili.numbers import ANGLE_NAMES, frozen_argument
from gyrostat.papers.claims import Claim, statement

BAND, FROM = 0.05, 50.0
"""rad and s: an angle is controlled if it stays this near to its goal from this time on. Without a
failure all angles do, with both laws."""
NEAR = 0.2
"""rad: "around the desired values"."""
MOVING = 1e-3
"""rad/s: a rate that has not converged to zero."""

SETTINGS = (
    f"An angle counts as controlled, stable or stabilised if it stays within {BAND:g} rad of its "
    f"goal (theta: pi/2) from {FROM:g} s to the end, and the run stays clear of the singularity; "
    "otherwise as unstable. Without a failure every angle passes with both laws.",
    "Better: the smaller root mean square of theta - pi/2, phi and psi together, from 15 s to "
    "where the first of the two runs ends.",
    "Sentences that only announce a case, a figure or a table carry no claim.",
)


def excursion(flight: Flight, angle: int) -> float:
    """Largest distance of an angle from its goal from `FROM` on, rad."""
    return float(np.max(np.abs(flight.after(FROM)[:, angle])))


def stays(flight: Flight, angle: int) -> bool:
    """Whether an angle stays within `BAND` of its goal for as long as the run is valid."""
    return excursion(flight, angle) <= BAND


def controlled(flight: Flight) -> bool:
    """Whether all angles are controlled to the end."""
    return flight.complete and all(stays(flight, angle) for angle in range(3))


def excursions(flight: Flight, angles: tuple[int, ...] = (0, 1, 2)) -> str:
    """How far angles come from their goals, in words."""
    told = [f"{ANGLE_NAMES[k]} {excursion(flight, k):.3g}" for k in angles]
    span = f"from {FROM:g} s to {flight.valid_until:.5g} s"
    return f"Largest distance from the goal {span}: {', '.join(told)} rad."


def refuted(name: str, quantity: str, flight: Flight) -> Claim:
    """A sentence that says that all angles are controlled, with the frozen-rate argument."""
    ends = ", ".join(
        f"{angle} {value:.3g}" for angle, value in zip(ANGLE_NAMES, flight.end, strict=True)
    )
    why = f"{frozen_argument(flight)} Errors at {flight.valid_until:.5g} s: {ends} rad."
    return statement(name, quantity, controlled(flight), why)


def spread(flight: Flight, until: float) -> float:
    """Root mean square of the three angles together from the failure to a time, rad."""
    angles = flight.angles[(flight.time >= 15.0 - 1e-9) & (flight.time <= until + 1e-9)]
    return float(np.sqrt(np.mean(np.sum(angles**2, axis=1))))


def compared(linear: Flight, dependent: Flight) -> tuple[float, float]:
    """`spread` of LQR and SDRE over the time that both are valid."""
    until = min(linear.valid_until, dependent.valid_until)
    return spread(linear, until), spread(dependent, until)
