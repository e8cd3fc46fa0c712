"""Section 6.2 of the paper and its conclusion, sentence by sentence."""

from collections.abc import Mapping

import numpy as np

from gyrostat._jax import jax, jnp
from gyrostat.body import EulerState
from gyrostat.papers.carvalho_fenili.flights import Flight
from gyrostat.papers.carvalho_fenili.judged import (
    NEAR,
    compared,
    controlled,
    excursion,
    excursions,
    refuted,
    stays,
)
from gyrostat.papers.carvalho_fenili.laws import (
    FACTORISATION,
    LinearQuadratic,
    gain,
    linearised,
    rank,
    regulated,
)
from gyrostat.papers.carvalho_fenili.numbers import Flights, frozen_argument
from gyrostat.papers.carvalho_fenili.printed import ANGLES, CASES, HEALTHY, INERTIA, RATES
from gyrostat.papers.claims import Claim, statement

EXCITED = 0.1
"""Share of the linear field that counts as sufficiently excited nonlinear terms."""


def sentences_sdre(flights: Flights) -> tuple[Claim, ...]:
    """Judge those of section 6.2, by the flights of both laws."""
    dependent = flights["sdre"]
    return (
        _excited(),
        *_one_failed(dependent),
        _better("Mz", "the nonlinear control shows the best results", flights),
        *_two_failed(dependent),
        _better("MxMz", "the SDRE results are better", flights),
        *_only_x(dependent["MyMz"]),
    )


def _excited() -> Claim:
    start = HEALTHY.start(ANGLES, RATES)
    torque = LinearQuadratic(jnp.asarray(gain()))(start)
    bend = HEALTHY.accelerations(start, torque)
    dynamics, torques = linearised()
    linear = (dynamics @ np.asarray(regulated(start)) + torques @ np.asarray(torque))[1::2]
    apart = np.linalg.norm(np.array([bend.theta, bend.phi, bend.psi]) - linear)
    share = float(apart / np.linalg.norm(linear))
    return statement(
        "sdre.nonlinear_terms_excited",
        "Table 2 excites the nonlinear terms sufficiently",
        share >= EXCITED,
        f"Under the LQR torque at the start the accelerations differ from the linearised ones by "
        f"{100 * share:.0f} % (asked: {100 * EXCITED:.0f} %).",
    )


def _one_failed(flights: Mapping[str, Flight]) -> list[Claim]:
    x, y, z = flights["Mx"], flights["My"], flights["Mz"]
    healthy = excursion(flights["none"], 0)
    return [
        statement(
            "sdre.Mx.unstable",
            "Mx failed: the system is unstable",
            not controlled(x),
            f"{excursions(x)} {frozen_argument(x)}",
        ),
        statement(
            "sdre.Mx.stays_around_the_goal",
            "Mx failed: the values are around the desired ones",
            all(excursion(x, angle) <= NEAR for angle in range(3)),
            f"{excursions(x)} Asked: {NEAR:g} rad. Theta goes on at the frozen rate.",
        ),
        statement(
            "sdre.Mx.does_not_converge",
            "Mx failed: the values do not converge to the desired ones",
            not controlled(x),
            excursions(x),
        ),
        refuted("sdre.My.all_angles_controlled", "My failed: stabilised as desired", y),
        statement(
            "sdre.My.coupling_is_seen",
            "My failed: the coupling between the angles is observed",
            excursion(y, 0) > 10.0 * healthy,
            f"Theta, whose torque works, is moved by {excursion(y, 0):.3g} rad; without a failure "
            f"by {healthy:.2g} rad.",
        ),
        refuted("sdre.Mz.all_angles_controlled", "Mz failed: stabilised in all angles", z),
        statement(
            "sdre.Mz.similar_to_My",
            "Mz failed: similar to the case of My",
            stays(z, 0) == stays(y, 0) and stays(z, 1) == stays(y, 2),
            f"{excursions(z)} With My failed: {excursions(y)}",
        ),
        refuted(
            "sdre.Mz.failure_compensated",
            "Mz failed: the coupling of theta and phi compensates the failure that acts on psi",
            z,
        ),
    ]


def _better(case: str, text: str, flights: Flights) -> Claim:
    linear, dependent = compared(flights["lqr"][case], flights["sdre"][case])
    return statement(
        f"sdre.{case}.better_than_lqr",
        f"{case} failed: {text}",
        dependent < linear,
        f"Root mean square of the angles {dependent:.3g} rad by SDRE, {linear:.3g} rad by LQR; "
        "neither holds the attitude.",
    )


def _two_failed(flights: Mapping[str, Flight]) -> list[Claim]:
    claims = []
    for case, reason, text in (
        ("MxMy", "psi_cannot_stabilise_the_others", "psi cannot stabilise the other angles"),
        ("MxMz", "phi_cannot_stabilise_the_others", "phi cannot stabilise the other angles"),
    ):
        flight = flights[case]
        claims += [
            statement(
                f"sdre.{case}.all_angles_unstable",
                f"{case} failed: instability in all the angles",
                not any(stays(flight, angle) for angle in range(3)),
                f"{excursions(flight)} Only what is beyond half a radian runs away.",
            ),
            statement(
                f"sdre.{case}.{reason}",
                f"{case} failed: {text}",
                rank(case) < 6 and not controlled(flight),
                f"Controllability rank {rank(case)} of 6. {frozen_argument(flight)}",
            ),
        ]
    return claims


def _only_x(flight: Flight) -> list[Claim]:
    torques = np.asarray(FACTORISATION(regulated(HEALTHY.start(ANGLES, RATES)))[1])
    return [
        refuted(
            "sdre.MyMz.all_angles_controlled",
            "My and Mz failed: with Mx alone all the angles are controlled",
            flight,
        ),
        statement(
            "sdre.MyMz.coupling_makes_it_possible",
            "My and Mz failed: possible because of the stronger dynamic coupling",
            rank("MyMz") == 6,
            f"Controllability rank {rank('MyMz')} of 6. {frozen_argument(flight)}",
        ),
        statement(
            "sdre.MyMz.Mx_moves_all_angles_strongly",
            "the wheel on x has strong influence on all three angles",
            np.min(np.abs(torques[[1, 3, 5], 0])) * INERTIA >= 0.5,
            "Of one unit of Mx over I, theta, phi and psi are accelerated at Table 2 by "
            f"{', '.join(f'{v:.2f}' for v in torques[[1, 3, 5], 0] * INERTIA)}; at the goal by 1, "
            "0, 0. Strong: 0.5 or more.",
        ),
    ]


def conclusion(flights: Flights) -> tuple[Claim, ...]:
    """Judge the sentences of section 7."""
    failing = [case for case in CASES if case != "none"]
    pairs = {case: compared(flights["lqr"][case], flights["sdre"][case]) for case in failing}
    better = [case for case, (linear, dependent) in pairs.items() if dependent < linear]
    runs = [flights[law][case] for law in flights for case in CASES]
    agree = all(controlled(run) == (0 not in run.failed) for run in runs)
    held = [run.case for run in runs if controlled(run)]
    start = HEALTHY.start(ANGLES, RATES)
    still = jax.jacfwd(lambda x: jnp.stack(HEALTHY.accelerations(EulerState(*x), jnp.zeros(3))))
    turned = float(np.max(np.abs(np.asarray(still(jnp.stack(start)))[:, [1, 2]])))
    torques = np.asarray(FACTORISATION(regulated(start))[1])[[1, 3, 5]]
    healthy = flights["lqr"]["none"]
    left = float(np.linalg.norm(healthy.body_rate[-1]) * INERTIA)
    first = float(np.linalg.norm(healthy.body_rate[0]) * INERTIA)
    return (
        statement(
            "conclusion.every_variable_moves_the_others",
            "a change of any angle or rate involves a change of the other two",
            turned > 0.0,
            "Without torque no acceleration depends on phi or psi (largest derivative "
            f"{turned:.1g}): turned by either, the motion is the same.",
        ),
        statement(
            "conclusion.torques_are_coupled",
            "the coupling also occurs with the torques",
            np.count_nonzero(np.abs(torques) > 1e-6) > 3,
            f"{np.count_nonzero(np.abs(torques) > 1e-6)} of 9 entries of B(x) are not zero at "
            "Table 2.",
        ),
        statement(
            "conclusion.actuators_are_momentum_wheels",
            "the actuators considered are momentum wheels",
            abs(left - first) < 1e-3 * first,
            f"(3) has no wheels: the healthy run takes the body's momentum from {first:.3f} to "
            f"{left:.1g} N·m·s, which wheels would have to hold. See gyrostat.*.",
        ),
        statement(
            "conclusion.one_or_two_actuators_fail",
            "in some cases one actuator fails, in some two",
            {len(failed) for failed in CASES.values()} == {0, 1, 2},
            "Three cases each.",
        ),
        statement(
            "conclusion.controlled_if_and_only_if_x_works",
            "satisfactorily controlled only if Mx does not fail, whatever the other two do",
            agree,
            f"Controlled: {len(held)} of {len(runs)} runs (case {', '.join(sorted(set(held)))}). "
            "Every failure freezes a rate, that of Mx no more than the others.",
        ),
        statement(
            "conclusion.euler_angles_explain_it",
            "the coupling and the choice of the angles explain it",
            agree,
            "There is nothing to explain; and what can be controlled does not depend on angles.",
        ),
        statement(
            "conclusion.sdre_better_in_many_cases",
            "in many situations SDRE gives better results than LQR",
            2 * len(better) > len(failing),
            f"Smaller root mean square of the angles in {len(better)} of {len(failing)} failures "
            f"({', '.join(better)}).",
        ),
    )
