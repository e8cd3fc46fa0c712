"""The paper's statements about its results, judged on the runs."""

from collections.abc import Sequence

import numpy as np

from gyrostat.papers.claims import Claim, statement
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Flight
from gyrostat.papers.endo_sekiguchi_nonaka.fragility import CASES, Outcome
from gyrostat.papers.endo_sekiguchi_nonaka.numbers import (
    SAMPLED_POLE,
    Flights,
    filtered,
    identity,
)
from gyrostat.papers.endo_sekiguchi_nonaka.printed import (
    DURATION,
    FEEDBACK,
    PERIOD,
    REQUIRED,
    SMOOTHING,
)

CLOSE = 0.1
"""Close to the ideal output: within this share of how far the output without MEC is from it."""
STEADY = 3.0 / FEEDBACK
"""s: three time constants, from which on only what the momentum does is left."""
GENTLE = 0.01
"""A gain changes gently if in no sample it changes by more than this share of its largest value."""
BOUNDED = 10.0
"""rad/s of wheel speed: four times what the start alone needs; beyond it the gain has run away."""
SETTINGS = (
    f"The objective: the pointing error is below {REQUIRED:g} degrees for good before the end.",
    f"Close to the ideal: root mean square distance of the outputs, over the whole run, below "
    f"{CLOSE:g} of that without MEC. Vibrational: each output turns round after {STEADY:.0f} s, "
    f"where exp(-F t) is below 0.05. Gently: no step above {GENTLE:g} of the largest gain.",
    "Sentences that announce a figure, a table or a method carry no claim.",
)


def distance(flight: Flight, ideal: Flight) -> float:
    """Root mean square over the run of the outputs' distance from the ideal ones."""
    return float(np.sqrt(np.mean(np.sum((flight.output - ideal.output) ** 2, axis=1))))


def turns(flight: Flight) -> list[int]:
    """How often each output turns round after `STEADY`."""
    slopes = np.sign(np.diff(flight.output[round(STEADY / PERIOD) :: 100], axis=0))
    return [int(np.sum(np.diff(slope) != 0.0)) for slope in slopes.T]


def _told(flight: Flight) -> str:
    end = f"{flight.error_at(DURATION):.3g} degrees at {DURATION:g} s"
    settled = flight.settled
    if settled is None:
        return f"Never below {REQUIRED:g} degrees for good; {end}."
    return f"Below {REQUIRED:g} degrees for good from {settled:.1f} s on; {end}."


def _output_sentences(flights: Flights) -> list[Claim]:
    bare, frit, ideal = flights.no_mec, flights.mec_frit, flights.ideal
    far, near = distance(bare, ideal), distance(frit, ideal)
    rounds = turns(bare)
    left = np.max(np.abs(bare.output[-30_000:]), axis=0)
    return [
        statement(
            "fig5_6.no_mec_vibrational",
            "without MEC both outputs become vibrational",
            min(rounds) > 0,
            f"Turns after {STEADY:.0f} s: {rounds[0]} of h1, {rounds[1]} of h2. They are as slow "
            "as the momentum, whose period is 10 000 s.",
        ),
        statement(
            "fig5_6.no_mec_not_zero",
            "without MEC both outputs cannot become zero",
            np.min(left) > 10.0 * np.max(np.abs(ideal.output[-1])),
            f"Largest |h1| and |h2| in the last 3000 s: {left[0]:.3g} and {left[1]:.3g}.",
        ),
        statement(
            "fig5_6.mec_close_to_ideal",
            "with the proposed method the output is close to the ideal one",
            near < CLOSE * far,
            f"Root mean square distance {near:.3g}; without MEC {far:.3g}.",
        ),
        statement(
            "fig7.no_mec_misses",
            "without MEC the control objective is not achieved",
            bare.settled is None,
            _told(bare),
        ),
        statement(
            "fig7.mec_frit_points",
            "the proposed method can point the antenna to the target direction",
            frit.settled is not None,
            _told(frit),
        ),
    ]


def _reason_sentences(flights: Flights) -> list[Claim]:
    frit, ideal = flights.mec_frit, flights.ideal
    fixed = {name: one for name, one in flights.fixed.items() if one.settled is not None}
    apart = {name: distance(one, ideal) for name, one in flights.fixed.items()}
    best = min(apart, key=lambda name: apart[name])
    change = np.max(np.abs(frit.speed - flights.no_mec.speed), axis=0)
    steps = np.abs(np.diff(frit.gain, axis=0))
    samples = int(np.sum(np.max(steps, axis=(1, 2)) > 0.0))
    jump = float(np.max(steps) / np.max(np.abs(frit.gain)))
    return [
        statement(
            "fig8.gain_updated_consecutively",
            "the compensation gain is updated consecutively",
            samples > 0,
            f"It changes in {samples} of {len(steps)} samples; the dead zone stops it in the rest.",
        ),
        statement(
            "fig8.update_is_the_reason",
            "the reason for the success is that the gain is updated consecutively",
            not fixed,
            f"Gains that are never updated do as well: {', '.join(fixed) or 'none'}.",
        ),
        statement(
            "fig9_10.input_modified",
            "as a result, the input is modified",
            np.min(change) > 0.0,
            f"By up to {change[0]:.3g} and {change[1]:.3g} rad/s against no MEC.",
        ),
        statement(
            "conclusion.mec_structure_is_the_reason",
            "this is because the input was modified by the MEC structure",
            bool(fixed) and flights.no_mec.settled is None,
            "MEC with a fixed gain is enough: it integrates the error against the model.",
        ),
        statement(
            "conclusion.gain_tuned_automatically",
            "moreover, the gain was tuned automatically",
            np.max(np.abs(frit.gain[-1])) > 0.0,
            f"From zero to {np.round(frit.gain[-1], 3).tolist()} 1/s, without a user's hand.",
        ),
        statement(
            "method.gain_becomes_optimum",
            "FRIT updates the parameter consecutively to become the optimum value",
            distance(frit, ideal) <= apart[best],
            f"Distance from the ideal output {distance(frit, ideal):.3g}; by {best}, never tuned, "
            f"{apart[best]:.3g}. The larger the gain, the nearer; the criterion does not see it.",
        ),
        statement(
            "method.gain_changes_gently",
            "by the low pass (30) the gain changes gently",
            jump <= GENTLE,
            f"Largest step in one sample: {jump:.2g} of the largest gain; with kappa = {SMOOTHING} "
            f"the low pass has a time constant of {-PERIOD / np.log(1.0 - SMOOTHING):.2g} s.",
        ),
    ]


def _general_sentences(flights: Flights, outcomes: Sequence[Outcome]) -> list[Claim]:
    held = sum(one.holds for one in outcomes)
    wild = sum(one.top_speed > BOUNDED for one in outcomes)
    lost = sum(one.valid_until < DURATION for one in outcomes)
    right, _ = identity(flights.mec_frit, SAMPLED_POLE)
    return [
        statement(
            "abstract.fluctuating_error_suppressed",
            "by FRIT the influence of the model error is suppressed even though it fluctuates",
            held == len(CASES),
            f"In the paper's own start, yes. In {held} of {len(CASES)} others: see fragility.*.",
        ),
        statement(
            "method.dead_zone_stops_divergence",
            "breaking off the update when the error is small suppresses destabilisation of K",
            wild == 0 and lost == 0,
            f"In {wild} of {len(CASES)} other starts the wheels are commanded beyond {BOUNDED:g} "
            f"rad/s; runs that diverge: {lost}.",
        ),
        statement(
            "introduction.exact_parameters_essential",
            "exact model parameters are essential because the controller is model based",
            flights.inertia_only.settled is None,
            f"With the 0.5 % inertia error alone: {_told(flights.inertia_only)} It is the unknown "
            "momentum that does the harm.",
        ),
        statement(
            "introduction.model_error_deteriorates",
            "with a model error high accuracy is not achieved by the model based law alone",
            flights.no_mec.settled is None,
            _told(flights.no_mec),
        ),
        statement(
            "equation_25.sign",
            "eta = M mu + F (h - M h), so that (23) is (22)",
            printed_residual(flights.mec_frit) < 1e-6,
            f"(22) has M mu - F (h - M h). Over max |M d|, what should vanish is "
            f"{printed_residual(flights.mec_frit):.3g} with the printed sign, {right:.1g} with the "
            "other.",
        ),
    ]


def printed_residual(flight: Flight) -> float:
    """Max |eta + M d| / max |M d| with (25) as printed, filters started at h(0)."""
    output, virtual = flight.output[:-1], flight.virtual[:-1]
    seen = filtered(np.diff(flight.output, axis=0) / PERIOD - virtual, SAMPLED_POLE)
    low = filtered(output, SAMPLED_POLE, output[0])
    eta = filtered(virtual, SAMPLED_POLE) + FEEDBACK * (output - low)
    return float(np.max(np.abs(eta + seen)) / np.max(np.abs(seen)))


def sentence_claims(flights: Flights, outcomes: Sequence[Outcome]) -> tuple[Claim, ...]:
    """Judge the paper's sentences.

    Args:
        flights: of the paper's own start.
        outcomes: with FRIT, from other starts.
    """
    return (
        *_output_sentences(flights),
        *_reason_sentences(flights),
        *_general_sentences(flights, outcomes),
    )
