"""Section 6.1 of the paper, sentence by sentence."""

from collections.abc import Mapping

import numpy as np

from gyrostat.papers.carvalho_fenili.flights import Flight
from gyrostat.papers.carvalho_fenili.judged import (
    MOVING,
    excursions,
    refuted,
    stays,
)
from gyrostat.papers.carvalho_fenili.laws import FACTORISATION, gain, linearised, rank, regulated
from gyrostat.papers.carvalho_fenili.numbers import ANGLE_NAMES, frozen_argument
from gyrostat.papers.carvalho_fenili.printed import ANGLES, AXES, HEALTHY, RATES
from gyrostat.papers.claims import Claim, statement

THETA, PHI, PSI = range(3)


def sentences_lqr(flights: Mapping[str, Flight]) -> tuple[Claim, ...]:
    """Judge them.

    Args:
        flights: by LQR, of each case.
    """
    return (
        *_torques(),
        *_one_failed(flights),
        *_two_failed(flights),
        *_only_x(flights["MyMz"]),
    )


def _torques() -> list[Claim]:
    gains = gain()
    claims = []
    for row, axis in enumerate(AXES):
        others = np.delete(gains[row], [2 * row, 2 * row + 1])
        name = ANGLE_NAMES[row]
        claims.append(
            statement(
                f"lqr.M{axis}_belongs_to_{name}",
                f"M{axis} is the torque associated to the angle {name}",
                np.max(np.abs(others)) < 1e-9 < gains[row, 2 * row],
                "So at theta = pi/2, psi = 0, where the gain has no other entries in its row; away "
                "from there B(x) mixes them.",
            )
        )
    return claims


def _one_failed(flights: Mapping[str, Flight]) -> list[Claim]:
    x, y, z = flights["Mx"], flights["My"], flights["Mz"]
    late = x.time >= x.valid_until - 10.0
    least = float(np.min(np.abs(x.rates[late, THETA])))
    ended = f"The run ends at {x.valid_until:.2f} s in the singularity theta = 0."
    closed, poles = _decoupled()
    similar = stays(z, THETA) == stays(y, THETA) and stays(z, PHI) == stays(y, PSI)
    return [
        statement(
            "lqr.Mx.theta_rate_does_not_converge",
            "Mx failed: the rate of theta does not converge to zero",
            least > MOVING,
            f"At least {least:.4f} rad/s in the last 10 s. {frozen_argument(x)}",
        ),
        statement(
            "lqr.Mx.theta_unstable",
            "Mx failed: instability in theta",
            not stays(x, THETA),
            f"{excursions(x, (THETA,))} {ended}",
        ),
        statement(
            "lqr.Mx.phi_unstable",
            "Mx failed: instability in phi",
            not stays(x, PHI),
            f"{excursions(x, (PHI,))} The paper's next sentence but one says the opposite.",
        ),
        statement(
            "lqr.Mx.phi_and_psi_to_zero",
            "Mx failed: My and Mz bring phi and psi to zero",
            stays(x, PHI) and stays(x, PSI),
            f"{excursions(x, (PHI, PSI))} {ended}",
        ),
        statement(
            "lqr.My.theta_and_psi_stable",
            "My failed: stable in the other two directions during the simulation",
            stays(y, THETA) and stays(y, PSI),
            excursions(y, (THETA, PSI)),
        ),
        statement(
            "lqr.My.coupling_is_the_reason",
            "My failed: they are stable because of the coupling between the angles",
            not closed,
            "Theta and psi have torques of their own: linearised, where nothing couples, their "
            f"poles without My are {poles} 1/s.",
        ),
        refuted(
            "lqr.My.failure_compensated",
            "My failed: theta and psi are able to compensate the failure that acts on phi",
            y,
        ),
        statement(
            "lqr.Mz.similar_to_My",
            "Mz failed: similar to the case of My",
            similar,
            f"{excursions(z, (THETA, PHI))} With My failed: {excursions(y, (THETA, PSI))} As psi "
            "winds on, the linear law pushes along axes that have turned away.",
        ),
        statement(
            "lqr.Mz.theta_and_phi_stable",
            "Mz failed: stable in the other two directions",
            stays(z, THETA) and stays(z, PHI),
            f"{excursions(z, (THETA, PHI))} They return for a while after each turn of psi.",
        ),
        refuted(
            "lqr.Mz.failure_compensated",
            "Mz failed: theta and phi are able to compensate the failure that acts on psi",
            z,
        ),
    ]


def _decoupled() -> tuple[bool, str]:
    """Whether theta and psi are stable without My where nothing couples, and their poles."""
    dynamics, torques = linearised()
    kept = [0, 1, 4, 5]
    without = torques.copy()
    without[:, 1] = 0.0
    closed = (dynamics - without @ gain())[np.ix_(kept, kept)]
    poles = np.sort(np.linalg.eigvals(closed).real)
    return bool(poles[-1] < 0.0), ", ".join(f"{pole:.3f}" for pole in poles)


def _unable(case: str, flight: Flight) -> str:
    return f"Controllability rank {rank(case)} of 6. {frozen_argument(flight)}"


def _two_failed(flights: Mapping[str, Flight]) -> list[Claim]:
    claims = []
    for case, reason, text in (
        ("MxMy", "psi_cannot_stabilise_the_others", "psi, the only controlled angle, cannot"),
        ("MxMz", "coupling_with_phi_does_not_suffice", "the coupling with phi cannot"),
    ):
        flight = flights[case]
        claims += [
            statement(
                f"lqr.{case}.all_angles_unstable",
                f"{case} failed: instability in all the angles",
                not any(stays(flight, angle) for angle in range(3)),
                excursions(flight),
            ),
            statement(
                f"lqr.{case}.{reason}",
                f"{case} failed: {text} stabilise or compensate the others",
                rank(case) < 6 and not all(stays(flight, angle) for angle in range(3)),
                _unable(case, flight),
            ),
        ]
    return claims


def _only_x(flight: Flight) -> list[Claim]:
    torques = np.asarray(FACTORISATION(regulated(HEALTHY.start(ANGLES, RATES)))[1])
    moved = torques[[1, 3, 5], 0]
    told = ", ".join(f"{value:.4f}" for value in moved)
    return [
        refuted(
            "lqr.MyMz.all_angles_controlled",
            "My and Mz failed: with Mx alone all the angles are controlled",
            flight,
        ),
        statement(
            "lqr.MyMz.coupling_makes_it_possible",
            "My and Mz failed: possible because of the dynamic coupling between the angles",
            rank("MyMz") == 6,
            f"{_unable('MyMz', flight)} Coupling of angles moves no momentum about y or z.",
        ),
        statement(
            "lqr.MyMz.Mx_moves_all_angles",
            "the wheel on x has influence on all three angles",
            np.all(np.abs(moved) > 1e-6),
            f"Column of Mx in B(x) at Table 2: {told} 1/(kg·m²) for theta, phi, psi. Influence is "
            "not control: it is one torque about one axis of the body.",
        ),
        statement(
            "lqr.MyMz.euler_angles_are_the_reason",
            "My and Mz failed: it happens because of the angles that were chosen",
            rank("MyMz") == 6,
            "What a torque can do to a body does not depend on the angles that describe it; the "
            "frozen rates are those of the body.",
        ),
    ]
