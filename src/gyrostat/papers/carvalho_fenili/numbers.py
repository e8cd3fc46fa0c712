"""What the paper's experiment gives in numbers; the paper prints none of them."""

from collections.abc import Mapping

import numpy as np

from gyrostat.papers.carvalho_fenili.flights import Flight
from gyrostat.papers.carvalho_fenili.laws import gain, rank
from gyrostat.papers.carvalho_fenili.printed import (
    AXES,
    CASES,
    DURATION,
    EDGE,
    FAILURE,
    INERTIA,
    LAWS,
    MASS,
    STEP,
    failure_of,
)
from gyrostat.papers.claims import Claim

ANGLE_NAMES = ("theta", "phi", "psi")

Flights = Mapping[str, Mapping[str, Flight]]
"""Of each law, then of each case."""


def design_claims() -> list[Claim]:
    """Inertia, gains and ranks."""
    gains = gain()
    rows = (("theta", 0, 0), ("phi", 1, 2), ("psi", 2, 4))
    claims = [
        Claim(
            "inertia",
            "moment of inertia of the cube",
            INERTIA,
            "kg·m²",
            f"m a² / 6 with {MASS:g} kg and {EDGE:g} m.",
        )
    ]
    for name, row, column in rows:
        axis = AXES[row]
        why = f"LQR, (16) with B(2,4) = 0; Q of (19), R of (20) where it acts: M{axis} = -K x."
        claims += [
            Claim(
                f"lqr.gain_{name}",
                f"gain of M{axis} on {name}",
                float(gains[row, column]),
                "N·m/rad",
                why,
            ),
            Claim(
                f"lqr.gain_{name}_rate",
                f"gain of M{axis} on the rate of {name}",
                float(gains[row, column + 1]),
                "N·m·s/rad",
                why,
            ),
        ]
    for case, failed in CASES.items():
        lost = " and ".join(ANGLE_NAMES[axis] for axis in failed) or "nothing"
        claims.append(
            Claim(
                f"rank.{case}",
                f"controllability rank of the linearised body-torque plant, {failure_of(case)}",
                float(rank(case)),
                "",
                f"Of 6; what is not controllable is {lost}.",
            )
        )
    return claims


def at_failure_claims(law: str, flight: Flight) -> list[Claim]:
    """State at 15 s, the same in every case."""
    row = round(FAILURE / STEP)
    name = LAWS[law]
    claims = [
        Claim(
            f"{law}.error_15s_{angle}",
            f"{angle}{' - pi/2' if angle == 'theta' else ''} at 15 s, {name}",
            float(flight.angles[row, k]),
            "rad",
            "Before any failure; angles are never reduced by whole turns.",
        )
        for k, angle in enumerate(ANGLE_NAMES)
    ]
    return claims + [
        Claim(
            f"{law}.rate_15s_{axis}",
            f"body rate about {axis} at 15 s, {name}",
            float(flight.body_rate[row, k]),
            "rad/s",
            f"If M{axis} fails now, this rate stays: I times its derivative is M{axis} = 0.",
        )
        for k, axis in enumerate(AXES)
    ]


def _followed(flight: Flight) -> bool:
    """Whether the steps are short enough for the motion to the end of validity."""
    return flight.resolved_until > flight.valid_until - 0.5 * STEP


def how_it_ended(flight: Flight) -> str:
    """The end of a run, one sentence."""
    if flight.complete:
        return f"Valid to {DURATION:g} s."
    if not _followed(flight):
        return (
            f"It spins up: from {flight.resolved_until:.2f} s on steps of {STEP:g} s are too long "
            f"for the passages by the singularity, and at {flight.valid_until:.2f} s a step fails."
        )
    return (
        f"Ends at {flight.valid_until:.2f} s in the singularity of the angles, sin(theta) < 0.005."
    )


def case_claims(law: str, flight: Flight, sampled: Flight) -> list[Claim]:
    """The end of one run.

    Args:
        law: key of the law.
        flight: its run with the law evaluated at every stage.
        sampled: the same, sampled and held.
    """
    case, name = flight.case, LAWS[law]
    of = f"{name}, {failure_of(case)}"
    ended = how_it_ended(flight)
    later = np.max(np.abs(flight.after(FAILURE)[:, 0]))
    claims = [
        Claim(
            f"{law}.{case}.{'theta_error' if angle == 'theta' else angle}",
            f"{angle}{' - pi/2' if angle == 'theta' else ''} at the end of validity, {of}",
            float(flight.end[k]),
            "rad",
            f"{ended} Sampled and held: {sampled.end[k]:.5g} at {sampled.valid_until:.2f} s.",
        )
        for k, angle in enumerate(ANGLE_NAMES)
    ]
    claims += [
        Claim(
            f"{law}.{case}.valid_until_s",
            f"end of validity, {of}",
            flight.valid_until,
            "s",
            f"{ended} Sampled and held: {sampled.valid_until:.2f} s.",
        ),
        Claim(
            f"{law}.{case}.max_theta_error_after_failure",
            f"largest |theta - pi/2| from {FAILURE:g} s to the end of validity, {of}",
            float(later),
            "rad",
            ended,
        ),
        _drift(law, flight, of),
        Claim(
            f"{law}.{case}.frozen_rate",
            f"length of the frozen rate, below which no law can bring the body, {of}",
            float(np.linalg.norm(flight.frozen_rate())),
            "rad/s",
            _frozen(flight),
        ),
        Claim(
            f"{law}.{case}.max_body_rate",
            f"largest body rate from {FAILURE:g} s on, as far as the steps resolve it, {of}",
            largest_rate(flight),
            "rad/s",
            f"At {FAILURE:g} s it is {rate_at_failure(flight):.4f} rad/s.",
        ),
    ]
    if not _followed(flight):
        claims.append(
            Claim(
                f"{law}.{case}.resolved_until_s",
                f"until when steps of {STEP:g} s follow the motion, {of}",
                flight.resolved_until,
                "s",
                "Then the body rate misses the torque's impulse by more than 1e-5 rad/s in a step; "
                "what comes after is the integrator's, with no meaning but that it spins up.",
            )
        )
    claims += [
        Claim(
            f"{law}.{case}.held.{'theta_error' if angle == 'theta' else angle}",
            f"{angle}{' - pi/2' if angle == 'theta' else ''} at the end, sampled and held, {of}",
            float(sampled.end[k]),
            "rad",
            f"Sampled each {STEP:g} s; valid to {sampled.valid_until:.2f} s.",
        )
        for k, angle in enumerate(ANGLE_NAMES)
    ]
    return [
        *claims,
        Claim(
            f"{law}.{case}.held.valid_until_s",
            f"end of validity, sampled and held, {of}",
            sampled.valid_until,
            "s",
            "To the singularity, or to a step that does not follow the motion.",
        ),
    ]


def _drift(law: str, flight: Flight, of: str) -> Claim:
    until = flight.resolved_until
    why = "Exact law: I dw/dt = M, so that it is zero; what is left is rounding and the step's."
    if not flight.failed:
        why = "No torque fails, so that no rate is frozen: the largest of none is 0."
    elif not _followed(flight):
        why += (
            f" To {until:.2f} s, while the steps resolve the motion; to the end of validity it is "
            f"{flight.frozen_rate_drift():.2g} rad/s, all of it error of the steps."
        )
    return Claim(
        f"{law}.{flight.case}.frozen_rate_drift",
        f"largest change from {FAILURE:g} s on of the body rate about the failed axes, {of}",
        flight.frozen_rate_drift(until),
        "rad/s",
        why,
    )


def _frozen(flight: Flight) -> str:
    if not flight.failed:
        return "Nothing failed."
    rates = [
        f"{rate:.5f} rad/s about {AXES[axis]}"
        for axis, rate in zip(flight.failed, flight.frozen_rate(), strict=True)
    ]
    return f"{' and '.join(rates)} from {FAILURE:g} s on."


def frozen_argument(flight: Flight) -> str:
    """Why a body whose torque failed cannot be brought to rest, with the numbers of a run."""
    drift = flight.frozen_rate_drift(flight.resolved_until)
    return (
        f"I dw/dt = M freezes {_frozen(flight)[:-1]} (changed by {drift:.1g} rad/s in the run): no "
        "law whatever can bring the body to rest."
    )


def rate_at_failure(flight: Flight) -> float:
    """Length of the body rate at 15 s, rad/s."""
    return float(np.linalg.norm(flight.body_rate[round(FAILURE / STEP)]))


def largest_rate(flight: Flight) -> float:
    """Largest body rate from 15 s on, while the steps resolve it, rad/s."""
    span = (flight.time >= FAILURE - 1e-9) & (flight.time <= flight.resolved_until + 1e-9)
    return float(np.max(np.linalg.norm(flight.body_rate[span], axis=1)))


def number_claims(flights: Flights, sampled: Flights) -> tuple[Claim, ...]:
    """All numbers of the paper's own plant.

    Args:
        flights: with the law evaluated at every stage.
        sampled: with the law sampled and held.
    """
    claims = design_claims()
    for law, runs in flights.items():
        claims += at_failure_claims(law, runs["none"])
        for case, flight in runs.items():
            claims += case_claims(law, flight, sampled[law][case])
    return tuple(claims)
