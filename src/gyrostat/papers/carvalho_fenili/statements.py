"""Sections 6 and 7 of the paper: its numbers and its statements on the 14 runs."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from gyrostat.core.jax64 import jax, jnp
from gyrostat.papers.carvalho_fenili import figures, setup
from gyrostat.papers.carvalho_fenili.flights import Flight, Flights, flights
from gyrostat.papers.carvalho_fenili.laws import (
    FACTORISATION,
    LinearQuadratic,
    gain,
    laws,
    linearised,
    rank,
    regulated,
)
from gyrostat.papers.carvalho_fenili.torque_driven import EulerState
from gyrostat.papers.claims import Value
from gyrostat.papers.reproduction import Part, Run

THETA, PHI, PSI = range(3)
NEAR = 0.2
"""Meaning of "around the desired values", rad."""
MOVING = 1e-3
"""Smallest rate that counts as not converged to zero, rad/s."""
EXCITED = 0.1
"""Nonlinear part, relative to the linear one, that counts as sufficiently excited."""


def flown(run: Run) -> Flights:
    """Simulate all cases with both laws."""
    run.say(f"{len(setup.CASES)} cases under each law, evaluated at every stage")
    with ThreadPoolExecutor() as pool:
        futures = {name: pool.submit(flights, law) for name, law in laws().items()}
        return {name: future.result() for name, future in futures.items()}


def design(run: Run) -> Part:
    """Inertia, gains and ranks."""
    gains = gain()
    values: dict[str, Value] = {"inertia": setup.INERTIA}
    for name, row, column in (("theta", 0, 0), ("phi", 1, 2)):
        values[f"lqr.gain_{name}"] = float(gains[row, column])
        values[f"lqr.gain_{name}_rate"] = float(gains[row, column + 1])
    for row, (axis, name) in enumerate(zip(setup.AXES, setup.ANGLE_NAMES, strict=True)):
        other_gains = np.delete(gains[row], [2 * row, 2 * row + 1])
        belongs = np.max(np.abs(other_gains)) < 1e-9 < gains[row, 2 * row]
        values[f"lqr.M{axis}_belongs_to_{name}"] = bool(belongs)
    return Part({**values, **{f"rank.{case}": float(rank(case)) for case in setup.CASES}})


def drawn(run: Run) -> Part:
    """Plot all runs."""
    by_law = run.once(flown)
    cases = (figures.case(case, by_law) for case in setup.CASES)
    return Part({}, by_law, (*cases, figures.frozen_rates(by_law)))


def numbers(run: Run) -> Part:
    """State at 15 s, and ends of the runs."""
    by_law: Flights = run.once(flown)
    linear, dependent = by_law["lqr"], by_law["sdre"]
    row = round(setup.FAILURE / setup.STEP)
    healthy, my, mz = linear["none"], linear["My"], linear["Mz"]
    values: dict[str, Value] = {
        **{
            f"lqr.error_15s_{n}": float(healthy.angles[row, k])
            for k, n in enumerate(setup.ANGLE_NAMES)
        },
        **{f"lqr.rate_15s_{n}": float(healthy.body_rate[row, k]) for k, n in enumerate(setup.AXES)},
        "lqr.Mx.valid_until_s": linear["Mx"].valid_until,
        "lqr.My.phi": float(my.end[PHI]),
        "lqr.My.frozen_rate_drift": my.frozen_rate_drift(my.resolved_until),
        "lqr.Mz.theta_error": float(mz.end[THETA]),
        "lqr.Mz.phi": float(mz.end[PHI]),
        "lqr.Mz.psi": float(mz.end[PSI]),
        "sdre.Mx.theta_error": float(dependent["Mx"].end[THETA]),
        "sdre.My.phi": float(dependent["My"].end[PHI]),
        "sdre.Mz.psi": float(dependent["Mz"].end[PSI]),
    }
    return Part(values)


def linear(run: Run) -> Part:
    """Section 6.1: statements on LQR."""
    by_case: Mapping[str, Flight] = run.once(flown)["lqr"]
    x, y, z = by_case["Mx"], by_case["My"], by_case["Mz"]
    late = x.time >= x.valid_until - 10.0
    least = float(np.min(np.abs(x.rates[late, THETA])))
    poles = _decoupled_poles()
    accelerations = _by_torques()[:, 0]
    values: dict[str, Value] = {
        "lqr.Mx.theta_rate_does_not_converge": least > MOVING,
        "lqr.Mx.theta_unstable": not x.stays(THETA),
        "lqr.Mx.phi_unstable": not x.stays(PHI),
        "lqr.Mx.phi_and_psi_to_zero": x.stays(PHI) and x.stays(PSI),
        "lqr.My.theta_and_psi_stable": y.stays(THETA) and y.stays(PSI),
        "lqr.My.coupling_is_the_reason": not poles[-1] < 0.0,
        "lqr.My.failure_compensated": y.controlled,
        "lqr.Mz.similar_to_My": (z.stays(THETA) == y.stays(THETA) and z.stays(PHI) == y.stays(PSI)),
        "lqr.Mz.theta_and_phi_stable": z.stays(THETA) and z.stays(PHI),
        "lqr.Mz.failure_compensated": z.controlled,
        **_unstable("lqr.MxMy", by_case, "psi_cannot_stabilise_the_others"),
        **_unstable("lqr.MxMz", by_case, "coupling_with_phi_does_not_suffice"),
        "lqr.MyMz.all_angles_controlled": by_case["MyMz"].controlled,
        "lqr.MyMz.coupling_makes_it_possible": rank("MyMz") == 6,
        "lqr.MyMz.Mx_moves_all_angles": bool(np.all(np.abs(accelerations) > 1e-6)),
        "lqr.MyMz.euler_angles_are_the_reason": rank("MyMz") == 6,
    }
    facts = {
        "least_rate": least,
        "poles": ", ".join(f"{pole:.3f}" for pole in poles),
        "moved": ", ".join(f"{value:.4f}" for value in accelerations),
        "rank": {case: rank(case) for case in setup.CASES},
    }
    return Part(values, facts)


def _unstable(prefix: str, by_case: Mapping[str, Flight], reason: str) -> dict[str, Value]:
    """Statements on two failures: all angles unstable, and the working torque cannot help."""
    case = prefix.split(".")[1]
    flight = by_case[case]
    stays = [flight.stays(angle) for angle in range(3)]
    return {
        f"{prefix}.all_angles_unstable": not any(stays),
        f"{prefix}.{reason}": rank(case) < 6 and not flight.controlled,
    }


def _decoupled_poles() -> np.ndarray:
    """Poles of theta and psi without My in the decoupled linear model, real parts in order, 1/s."""
    dynamics, torques = linearised()
    states = [0, 1, 4, 5]
    inputs = torques.copy()
    inputs[:, 1] = 0.0
    closed_loop = (dynamics - inputs @ gain())[np.ix_(states, states)]
    return np.sort(np.linalg.eigvals(closed_loop).real)


def dependent(run: Run) -> Part:
    """Section 6.2: statements on SDRE."""
    by_law: Flights = run.once(flown)
    runs = by_law["sdre"]
    x, y, z = runs["Mx"], runs["My"], runs["Mz"]
    healthy = runs["none"].excursion(THETA)
    accelerations = setup.INERTIA * _by_torques()[:, 0]
    share = _nonlinear_share()
    spreads = {case: _spreads(by_law, case) for case in setup.FAILING}
    values: dict[str, Value] = {
        "sdre.nonlinear_terms_excited": share >= EXCITED,
        "sdre.Mx.unstable": not x.controlled,
        "sdre.Mx.stays_around_the_goal": all(x.excursion(k) <= NEAR for k in range(3)),
        "sdre.Mx.does_not_converge": not x.controlled,
        "sdre.My.all_angles_controlled": y.controlled,
        "sdre.My.coupling_is_seen": y.excursion(THETA) > 10.0 * healthy,
        "sdre.Mz.all_angles_controlled": z.controlled,
        "sdre.Mz.similar_to_My": (
            z.stays(THETA) == y.stays(THETA) and z.stays(PHI) == y.stays(PSI)
        ),
        "sdre.Mz.failure_compensated": z.controlled,
        **{
            f"sdre.{case}.better_than_lqr": spreads[case][1] < spreads[case][0]
            for case in ("Mz", "MxMz")
        },
        **_unstable("sdre.MxMy", runs, "psi_cannot_stabilise_the_others"),
        **_unstable("sdre.MxMz", runs, "phi_cannot_stabilise_the_others"),
        "sdre.MyMz.all_angles_controlled": runs["MyMz"].controlled,
        "sdre.MyMz.coupling_makes_it_possible": rank("MyMz") == 6,
        "sdre.MyMz.Mx_moves_all_angles_strongly": bool(np.min(np.abs(accelerations)) >= 0.5),
    }
    facts = {
        "nonlinear_percent": 100.0 * share,
        "theta_moved": y.excursion(THETA),
        "theta_healthy": healthy,
        "spreads": spreads,
        "strongly_moved": ", ".join(f"{value:.2f}" for value in accelerations),
    }
    return Part(values, facts)


def _by_torques() -> np.ndarray:
    """Accelerations of theta, phi and psi by each torque at the start, (3, 3), 1/(kg·m²)."""
    return np.asarray(FACTORISATION(regulated(setup.START))[1])[[1, 3, 5]]


def _nonlinear_share() -> float:
    """Nonlinear part of the initial accelerations under LQR, relative to the linearised ones."""
    start = setup.START
    torque = LinearQuadratic(jnp.asarray(gain()))(start)
    bend = setup.HEALTHY.accelerations(start, torque)
    dynamics, torques = linearised()
    linear = (dynamics @ np.asarray(regulated(start)) + torques @ np.asarray(torque))[1::2]
    difference = np.linalg.norm(np.array([bend.theta, bend.phi, bend.psi]) - linear)
    return float(difference / np.linalg.norm(linear))


def _spreads(by_law: Flights, case: str) -> tuple[float, float]:
    """`Flight.spread` with LQR and with SDRE over the time for which both are valid."""
    linear, dependent = by_law["lqr"][case], by_law["sdre"][case]
    until = min(linear.valid_until, dependent.valid_until)
    return linear.spread(until), dependent.spread(until)


def conclusion(run: Run) -> Part:
    """Section 7: statements on all runs."""
    by_law: Flights = run.once(flown)
    pairs = {case: _spreads(by_law, case) for case in setup.FAILING}
    better = [case for case, (linear, dependent) in pairs.items() if dependent < linear]
    runs = [by_law[law][case] for law in by_law for case in setup.CASES]
    agree = all(run.controlled == (0 not in run.failed) for run in runs)
    cases = [run.case for run in runs if run.controlled]
    still = jax.jacfwd(
        lambda x: jnp.stack(setup.HEALTHY.accelerations(EulerState(*x), jnp.zeros(3)))
    )
    turned = float(np.max(np.abs(np.asarray(still(jnp.stack(setup.START)))[:, [1, 2]])))
    entries = int(np.count_nonzero(np.abs(_by_torques()) > 1e-6))
    rates = np.linalg.norm(by_law["lqr"]["none"].body_rate[[0, -1]], axis=1)
    initial, final = (float(setup.INERTIA * rate) for rate in rates)
    values: dict[str, Value] = {
        "conclusion.every_variable_moves_the_others": turned > 0.0,
        "conclusion.torques_are_coupled": entries > 3,
        "conclusion.actuators_are_momentum_wheels": abs(final - initial) < 1e-3 * initial,
        "conclusion.one_or_two_actuators_fail": {len(f) for f in setup.CASES.values()} == {0, 1, 2},
        "conclusion.controlled_if_and_only_if_x_works": agree,
        "conclusion.euler_angles_explain_it": agree,
        "conclusion.sdre_better_in_many_cases": 2 * len(better) > len(setup.FAILING),
    }
    facts = {
        "turned": turned,
        "entries": entries,
        "momenta": (initial, final),
        "held": f"{len(cases)} of {len(runs)} runs (case {', '.join(sorted(set(cases)))})",
        "better": f"{len(better)} of {len(setup.FAILING)} failures ({', '.join(better)})",
    }
    return Part(values, facts)


EXPERIMENTS = (design, numbers, linear, dependent, conclusion, drawn)
