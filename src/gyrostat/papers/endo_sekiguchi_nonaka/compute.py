"""Numbers and statements of the paper, from its own start and from others."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from gyrostat.papers.claims import Value
from gyrostat.papers.endo_sekiguchi_nonaka import figures, setup
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Case, Flight, flown
from gyrostat.papers.reproduction import Part, Run

FIXED = {
    "fixed_gain_0p01": 0.01,
    "fixed_gain_0p03": 0.03,
    "fixed_gain_0p1": 0.1,
    "fixed_gain_1": 1.0,
}
"""Runs with a fixed gain, 1/s."""
SAMPLED_POLE = 1.0 - setup.FEEDBACK * setup.PERIOD
"""Pole of the sampled closed loop of integrators, h(k+1) = h(k) + Ts F (r - h)."""
CLOSE = 0.1
"""Largest distance from the ideal output that counts as close, relative to that without MEC."""
STEADY = 3.0 / setup.FEEDBACK
"""Three time constants, s, after which only the effect of the momentum remains."""
GENTLE = 0.01
"""Largest change per sample, relative to the largest gain, that counts as gentle."""
BOUNDED = 10.0
"""Wheel speed above which the gain has diverged, rad/s: four times the need of the start."""
IN_TIME = 9000.0
"""Time, s, from which a run from another start must stay below 0.05 degrees."""
TURNS = (45, 90, 135, 180, 225, 270, 315)
"""Angles added to the phases of the momentum, degrees."""
AXES = (
    *((1.0, 2.0, -3.0), (2.0, 1.0, 3.0), (-1.0, 2.0, 3.0), (1.0, -2.0, 3.0)),
    *((3.0, 2.0, 1.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
)
"""Other initial rotation axes."""
OTHERS = (
    *(Case(shift=float(np.deg2rad(turn))) for turn in TURNS),
    *(Case(axis=axis) for axis in AXES),
    Case(torque_limit=0.1),
)
"""Other starts, each with one change."""


Flights = Mapping[str, Flight]
"""Runs of the paper's own start. Without compensator: `ideal` (no momentum, nominal inertia),
`no_mec`, `inertia_only` (wrong inertia, no momentum), `known_momentum` (from measurements). With
the compensator: fixed gains, by the names of `FIXED`, and on-line tuning, `mec_frit`."""


class Outcome(NamedTuple):
    """Summary of a run from another start.

    Attributes:
        settled: Time from which the error stays below 0.05 degrees, s; None if never.
        top_speed: Largest commanded wheel speed, rad/s.
        valid_until: End of validity, s.
    """

    settled: float | None
    top_speed: float
    valid_until: float

    @property
    def holds(self) -> bool:
        """Whether the run settled in time."""
        return self.settled is not None and self.settled <= IN_TIME


def outcomes_of(flights: Iterable[Flight]) -> list[Outcome]:
    """Summaries of runs from other starts."""
    return [Outcome(flight.settled, flight.top_speed, flight.valid_until) for flight in flights]


def own_start(run: Run) -> tuple[Flights, list[Outcome]]:
    """Simulate the paper's own start, and the other starts with FRIT."""
    base = Case()
    untuned = {
        "ideal": (Case(total=setup.NOMINAL, momentum=0.0), 0.0),
        "no_mec": (base, 0.0),
        "inertia_only": (Case(momentum=0.0), 0.0),
        **{name: (base, gain) for name, gain in FIXED.items()},
    }
    run.say(f"{len(untuned)} runs of 10 000 s without tuning")
    cases = [case for case, _ in untuned.values()]
    runs = flown(cases, [setup.fixed(gain) for _, gain in untuned.values()])
    flights = dict(zip(untuned, runs, strict=True))
    run.say(f"FRIT, from {len(OTHERS)} other starts too")
    frit_runs = flown([base, *OTHERS], [setup.tuned()] * (1 + len(OTHERS)))
    flights["mec_frit"] = next(frit_runs)
    outcomes = outcomes_of(frit_runs)
    run.say("simulating with the momentum computed from measurements")
    (flights["known_momentum"],) = flown([base], [setup.law(momentum_measured=True)])
    return flights, outcomes


def filtered(signal: np.ndarray, start: np.ndarray | float = 0.0) -> np.ndarray:
    """Filter M: m(k+1) = a m(k) + (1 - a) x(k), a = `SAMPLED_POLE`; (N, n) along the first axis.

    Args:
        signal: Signal x, (N, n).
        start: Initial value m(0).
    """
    initial = np.broadcast_to(start, signal.shape[1:])[None]
    numerator, denominator = [0.0, 1.0 - SAMPLED_POLE], [1.0, -SAMPLED_POLE]
    return np.asarray(lfilter(numerator, denominator, signal, axis=0, zi=initial)[0])


def identity(flight: Flight, sign: float = -1.0) -> float:
    """Max |eta + M d| / max |M d|, eta = M mu + sign F (h - M h), d = (h(k+1) - h(k)) / Ts - mu(k).

    M is the sampled closed loop. The filters of (25) start at h(0).

    Args:
        flight: Run with the signals h and mu.
        sign: -1 where (25) agrees with (22), +1 as (25) is printed.
    """
    output, virtual = flight.output[:-1], flight.virtual[:-1]
    disturbance = filtered(np.diff(flight.output, axis=0) / setup.PERIOD - virtual)
    eta = filtered(virtual) + sign * setup.FEEDBACK * (output - filtered(output, output[0]))
    return float(np.max(np.abs(eta + disturbance)) / np.max(np.abs(disturbance)))


def turns(flight: Flight) -> list[int]:
    """Number of reversals of each output after `STEADY`."""
    slopes = np.sign(np.diff(flight.output[round(STEADY / setup.PERIOD) :: 100], axis=0))
    return [int(np.sum(np.diff(slope) != 0.0)) for slope in slopes.T]


def numbers(run: Run) -> Part:
    """Numbers and figures of the paper's own start."""
    flights, _ = run.once(own_start)
    uncompensated, frit = flights["no_mec"], flights["mec_frit"]
    values: dict[str, Value] = {
        "pointing.initial_deg": frit.error_at(0.0),
        "ideal.settle_0p05deg_s": flights["ideal"].settled,
        **{
            f"no_mec.error_{time}s_deg": uncompensated.error_at(float(time))
            for time in (1000, 5000, 7000, 10000)
        },
        "no_mec.rms_deg": float(np.sqrt(np.mean(uncompensated.judged**2))),
        "no_mec.max_deg": float(np.max(uncompensated.judged)),
        **{
            f"{name}.error_10000s_deg": flights[name].error_at(setup.DURATION)
            for name in list(FIXED)[:3]
        },
        "mec_frit.error_10000s_deg": frit.error_at(setup.DURATION),
        "mec_frit.settle_0p05deg_s": frit.settled,
        "mec_frit.max_wheel_speed_rad_s": frit.top_speed,
        **{
            f"mec_frit.gain_final_{row + 1}{column + 1}": float(frit.gain[-1, row, column])
            for row in range(2)
            for column in range(2)
        },
        "no_mec_known_momentum.error_10000s_deg": flights["known_momentum"].error_at(
            setup.DURATION
        ),
        "frit.identity_residual": identity(frit),
    }
    return Part(values, {}, figures.figures(flights))


def statements(run: Run) -> Part:
    """Statements on the paper's own start, and on the other starts with FRIT."""
    flights, outcomes = run.once(own_start)
    uncompensated, frit, ideal = flights["no_mec"], flights["mec_frit"], flights["ideal"]
    far, near = uncompensated.distance(ideal), frit.distance(ideal)
    rounds = turns(uncompensated)
    final_output = np.max(np.abs(uncompensated.output[-30_000:]), axis=0)
    settling = [name for name in FIXED if flights[name].settled is not None]
    distances = {name: flights[name].distance(ideal) for name in FIXED}
    best = min(distances, key=lambda name: distances[name])
    change = np.max(np.abs(frit.speed - uncompensated.speed), axis=0)
    steps = np.abs(np.diff(frit.gain, axis=0))
    samples = int(np.sum(np.max(steps, axis=(1, 2)) > 0.0))
    jump = float(np.max(steps) / np.max(np.abs(frit.gain)))
    success_count = sum(outcome.holds for outcome in outcomes)
    diverged_count = sum(outcome.top_speed > BOUNDED for outcome in outcomes)
    incomplete_count = sum(outcome.valid_until < setup.DURATION for outcome in outcomes)
    printed = identity(frit, 1.0)
    ends = np.max(np.abs(ideal.output[-1]))
    values: dict[str, Value] = {
        "fig5_6.no_mec_vibrational": min(rounds) > 0,
        "fig5_6.no_mec_not_zero": bool(np.min(final_output) > 10.0 * ends),
        "fig5_6.mec_close_to_ideal": near < CLOSE * far,
        "fig7.no_mec_misses": uncompensated.settled is None,
        "fig7.mec_frit_points": frit.settled is not None,
        "fig8.gain_updated_consecutively": samples > 0,
        "fig8.update_is_the_reason": not settling,
        "fig9_10.input_modified": bool(np.min(change) > 0.0),
        "conclusion.mec_structure_is_the_reason": bool(settling) and uncompensated.settled is None,
        "conclusion.gain_tuned_automatically": bool(np.max(np.abs(frit.gain[-1])) > 0.0),
        "method.gain_becomes_optimum": near <= distances[best],
        "method.gain_changes_gently": jump <= GENTLE,
        "abstract.fluctuating_error_suppressed": success_count == len(OTHERS),
        "method.dead_zone_stops_divergence": diverged_count == 0 and incomplete_count == 0,
        "introduction.exact_parameters_essential": flights["inertia_only"].settled is None,
        "introduction.model_error_deteriorates": uncompensated.settled is None,
        "equation_25.sign": printed < 1e-6,
    }
    facts = {
        "flights": flights,
        "rounds": rounds,
        "left": final_output,
        "near": near,
        "far": far,
        "samples": samples,
        "settling": ", ".join(settling) or "none",
        "change": change,
        "final": np.round(frit.gain[-1], 3).tolist(),
        "best": best,
        "best_distance": distances[best],
        "jump": jump,
        "smoothing_time": -setup.PERIOD / np.log(1.0 - setup.SMOOTHING),
        "required_ratio": float(np.sqrt(np.mean(uncompensated.judged**2))) / setup.REQUIRED,
        "first_torque": float(np.max(np.abs(frit.speed[0])) * setup.ROTOR / setup.PERIOD),
        "others": len(OTHERS),
        "holding": success_count,
        "wild": diverged_count,
        "lost": incomplete_count,
        "printed_residual": printed,
    }
    return Part(values, facts)
