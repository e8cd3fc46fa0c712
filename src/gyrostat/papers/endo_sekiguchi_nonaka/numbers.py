"""What the experiment gives in numbers; the paper prints none of them but its requirement."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from gyrostat.papers.claims import Claim
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Flight
from gyrostat.papers.endo_sekiguchi_nonaka.printed import (
    DURATION,
    FEEDBACK,
    PERIOD,
    REQUIRED,
    ROTOR,
)

GAINS = {"fixed_gain_0p01": 0.01, "fixed_gain_0p03": 0.03, "fixed_gain_0p1": 0.1}
SAMPLED_POLE = 1.0 - FEEDBACK * PERIOD
"""Of the sampled closed loop of integrators, h(k+1) = h(k) + Ts F (r - h)."""
EXACT_POLE = float(np.exp(-FEEDBACK * PERIOD))
"""Of F / (s + F), sampled."""


@dataclass(frozen=True)
class Flights:
    """The runs of the paper's own start.

    Attributes:
        ideal: no momentum, nominal inertia.
        no_mec: neither compensated.
        fixed: with a fixed gain, by id, and with the gain 1.
        mec_frit: with on-line tuning.
        printed_sign: the same with the sign of (25) as printed.
        from_output: the same with the filter of h started at h(0).
        known_momentum: no compensator, the momentum computed from measurements.
        inertia_only: no compensator, wrong inertia, no momentum.
        momentum_only: no compensator, right inertia, unknown momentum.
    """

    ideal: Flight
    no_mec: Flight
    fixed: dict[str, Flight]
    mec_frit: Flight
    printed_sign: Flight
    from_output: Flight
    known_momentum: Flight
    inertia_only: Flight
    momentum_only: Flight


def filtered(signal: np.ndarray, pole: float, start: np.ndarray | float = 0.0) -> np.ndarray:
    """M: m(k+1) = a m(k) + (1 - a) x(k), (N, n) along the first axis.

    Args:
        signal: (N, n) x.
        pole: a.
        start: m(0).
    """
    first = np.broadcast_to(start, signal.shape[1:])[None]
    return np.asarray(lfilter([0.0, 1.0 - pole], [1.0, -pole], signal, axis=0, zi=first)[0])


def identity(flight: Flight, pole: float) -> tuple[float, float]:
    """How well M mu - F (h - M h) = -M d holds in a run, d = (h(k+1) - h(k)) / Ts - mu(k).

    Args:
        flight: of signals h and mu.
        pole: of M.

    Returns:
        max |eta + M d| / max |M d| with the filter of h started at h(0); and the largest part of
        eta that starting it at zero adds, over max |M d|.
    """
    output, virtual = flight.output[:-1], flight.virtual[:-1]
    disturbance = np.diff(flight.output, axis=0) / PERIOD - virtual
    seen = filtered(disturbance, pole)

    def eta(start: np.ndarray | float) -> np.ndarray:
        low = filtered(output, pole, start)
        return filtered(virtual, pole) - FEEDBACK * (output - low)

    size = np.max(np.abs(seen))
    exact = eta(output[0])
    return (
        float(np.max(np.abs(exact + seen)) / size),
        float(np.max(np.abs(eta(0.0) - exact)) / size),
    )


def _at(name: str, label: str, flight: Flight, times: tuple[float, ...], why: str) -> list[Claim]:
    return [
        Claim(
            f"{name}.error_{time:g}s_deg",
            f"pointing error at {time:g} s, {label}",
            flight.error_at(time),
            "deg",
            why,
        )
        for time in times
    ]


def settle_claim(name: str, label: str, flight: Flight, why: str) -> Claim:
    """From when on a run is below 0.05 degrees for good; a run that never is cannot be timed."""
    settled = flight.settled
    return Claim(
        name,
        f"time from which the pointing error is below {REQUIRED:g} degrees for good, {label}",
        settled,
        "s",
        why if settled is not None else f"Never within {DURATION:g} s. {why}",
    )


def number_claims(flights: Flights) -> tuple[Claim, ...]:
    """All numbers of the paper's own start."""
    frit, bare = flights.mec_frit, flights.no_mec
    end = (DURATION,)
    seen = bare.judged
    claims = [
        Claim(
            "pointing.initial_deg",
            "pointing error at the start",
            frit.error_at(0.0),
            "deg",
            "2 asin sqrt(q1² + q2²) for 30 degrees about (1, 2, 3).",
        ),
        settle_claim(
            "ideal.settle_0p05deg_s",
            "without model error",
            flights.ideal,
            "Both outputs fall as exp(-F t).",
        ),
        *_at("no_mec", "no MEC", bare, (1000.0, 5000.0, 7000.0, *end), "The momentum is unknown."),
        Claim(
            "no_mec.rms_deg",
            "root mean square of the pointing error from 7000 to 10 000 s, no MEC",
            float(np.sqrt(np.mean(seen**2))),
            "deg",
            f"{float(np.sqrt(np.mean(seen**2))) / REQUIRED:.0f} times what is required.",
        ),
        Claim(
            "no_mec.max_deg",
            "largest pointing error from 7000 to 10 000 s, no MEC",
            float(np.max(seen)),
            "deg",
            "About |H| / (J F): the drift that the feedback must balance.",
        ),
    ]
    for name, gain in GAINS.items():
        flight = flights.fixed[name]
        claims += [
            *_at(name, f"MEC with K = {gain:g}", flight, end, "No tuning."),
            settle_claim(
                f"{name}.settle_0p05deg_s", f"MEC with K = {gain:g}", flight, "No tuning."
            ),
        ]
    claims += [
        *_at("mec_frit", "MEC with FRIT", frit, end, "The paper's proposal, (25) corrected."),
        settle_claim(
            "mec_frit.settle_0p05deg_s",
            "MEC with FRIT",
            frit,
            "The paper shows that it settles, not when.",
        ),
        Claim(
            "mec_frit.max_wheel_speed_rad_s",
            "largest commanded wheel speed, MEC with FRIT",
            frit.top_speed,
            "rad/s",
            "The wheels take it in one sample.",
        ),
        *(
            Claim(
                f"mec_frit.gain_final_{row + 1}{column + 1}",
                f"K_{row + 1}{column + 1} at 10 000 s",
                float(frit.gain[-1, row, column]),
                "1/s",
                "Where the dead zone left it: any gain of this size does.",
            )
            for row in range(2)
            for column in range(2)
        ),
        *_at(
            "no_mec_known_momentum",
            "no MEC, momentum computed from rate, wheel speeds and nominal inertia",
            flights.known_momentum,
            end,
            "Linearised with the computed momentum, nothing is left to compensate.",
        ),
    ]
    return (*claims, *_reasons(flights))


def _reasons(flights: Flights) -> list[Claim]:
    frit = flights.mec_frit
    residual, transient = identity(frit, SAMPLED_POLE)
    other, _ = identity(frit, EXACT_POLE)
    first = float(np.max(np.abs(frit.speed[0])) * ROTOR / PERIOD)
    return [
        Claim(
            "frit.identity_residual",
            "max |eta + M d| / max |M d|, M the sampled closed loop, filters started at h(0)",
            residual,
            "",
            "eta is the disturbance through the reference model, whatever gain is in use: the "
            "estimate says which K would have made K e = -d, which every K does once e = -d / K.",
        ),
        Claim(
            "frit.identity_residual_exponential",
            "the same with M = F/(s+F), sampled, as in the runs",
            other,
            "",
            "exp(-F Ts) is not 1 - F Ts: half of F Ts times M dh/dt is left.",
        ),
        Claim(
            "frit.start_transient_ratio",
            "what starting the filter of h at zero adds to eta, over max |M d|",
            transient,
            "",
            "F h(0) exp(-F t): the paper's success rests on a regression that this swamps.",
        ),
        *_at(
            "mec_frit_filter_from_output",
            "MEC with FRIT, filter of h started at h(0)",
            flights.from_output,
            (DURATION,),
            "The other reading of the filters' start. " + _held(flights.from_output),
        ),
        Claim(
            "mec_frit_printed_sign.valid_until_s",
            "until when MEC with FRIT and (25) as printed has not diverged",
            flights.printed_sign.valid_until,
            "s",
            _held(flights.printed_sign),
        ),
        *_at(
            "inertia_error_only",
            "no MEC, wrong inertia, no momentum",
            flights.inertia_only,
            (DURATION,),
            _held(flights.inertia_only),
        ),
        *_at(
            "momentum_only",
            "no MEC, right inertia, unknown momentum",
            flights.momentum_only,
            (DURATION,),
            _held(flights.momentum_only),
        ),
        Claim(
            "first_sample.wheel_torque",
            "torque that a wheel would need for the speed of the first sample",
            first,
            "N·m",
            "From rest to the first command within one period; wheels of this size give 0.1 N·m.",
        ),
    ]


def _held(flight: Flight) -> str:
    if flight.valid_until < DURATION:
        return f"Diverges at {flight.valid_until:.1f} s."
    if flight.settled is None:
        return f"Never below {REQUIRED:g} degrees for good."
    return f"Below {REQUIRED:g} degrees for good from {flight.settled:.1f} s on."
