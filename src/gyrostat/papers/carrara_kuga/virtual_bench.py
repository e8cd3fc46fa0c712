"""The paper's two experiments on a virtual wheel: record, estimate, predict."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat._jax import jax
from gyrostat._types import Matrix, Vector
from gyrostat.identify import Fit, identify
from gyrostat.identify.statistics import crossing_times
from gyrostat.papers.carrara_kuga.printed import (
    DETERMINISTIC,
    DURATION,
    INERTIA,
    NAMES,
    SPEED_SIGMA,
    START,
    STATISTICAL,
    STRIBECK_SPEED,
)
from gyrostat.papers.reproduction import Say
from gyrostat.simulate import CurrentRange, Telemetry, bench_record
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, speed_response

RATE = 10.0
"""Samples per second, Hz."""
STEP_CURRENTS = CurrentRange(0.06, 0.15)
"""A, of profile 2."""
STEP_PERIOD = 30.0
"""s, of one step of profile 2, from the paper."""
SINE_CURRENTS = CurrentRange(0.08, 0.20)
"""A, of profile 1."""
SINE_PERIOD = 24.0
"""s, mean of profile 1: 12.5 cycles in 300 s."""
PRIOR_SIGMA = (5.0, 0.002, 0.3, 0.6)
"""A-priori sigmas of x2..x5 about eq. (15), in its units."""
PROFILE1_SEEDS = 1_000_000
"""Added to a seed for its profile 1: the noise must not be that of its profile 2."""

_respond = jax.jit(speed_response)


def modelled_speed(wheel: Wheel, time: Vector, current: Vector, initial_speed: float) -> Vector:
    """Speed of a wheel whose current is held between samples, rad/s.

    Args:
        wheel: the wheel.
        time: (N,) s.
        current: (N,) A.
        initial_speed: rad/s.
    """
    speed, resolved = _respond(wheel, time, current, initial_speed)
    assert bool(resolved)  # at these rates every curve here is
    return np.asarray(speed)


def profile1(seed: int, period: float = SINE_PERIOD) -> Record:
    """Sine cycles of random amplitude and period, the paper's validation record."""
    return _record("sines", SINE_CURRENTS, period, seed + PROFILE1_SEEDS, "profile 1")


def profile2(seed: int) -> Record:
    """Steps of random amplitude that reverse every 30 s, the paper's estimation record."""
    return _record("steps", STEP_CURRENTS, STEP_PERIOD, seed, "profile 2")


def _record(profile: str, amplitudes: CurrentRange, period: float, seed: int, name: str) -> Record:
    return bench_record(
        STATISTICAL.wheel(),
        profile,
        duration=DURATION,
        telemetry=Telemetry(rate=RATE, speed_sigma=SPEED_SIGMA),
        amplitudes=amplitudes,
        period=period,
        seed=seed,
        name=name,
    )


def estimate(record: Record, *, stribeck_speed: float | None = STRIBECK_SPEED) -> Fit:
    """Estimate x2..x5 as the paper does, x1(0) = 0 known.

    Args:
        record: to fit.
        stribeck_speed: rad/s, held; None to estimate it as well.
    """
    held: dict[str, Any] = {"initial_speed": 0.0}
    if stribeck_speed is not None:
        held["stribeck_speed"] = stribeck_speed
    return identify(
        record,
        inertia=INERTIA,
        hold=held,
        free=["stribeck_speed"] if stribeck_speed is None else [],
        prior={
            name: (INERTIA * mean, INERTIA * sigma)
            for name, mean, sigma in zip(NAMES, START, PRIOR_SIGMA, strict=True)
        },
        speed_sigma=SPEED_SIGMA,
        white_noise=True,
    )


@dataclass(frozen=True, eq=False)
class Prediction:
    """One record and what wheels make of its current.

    Attributes:
        record: measured.
        true: speed of the true wheel, without noise, rad/s.
        statistical: speed of the estimated wheel, rad/s.
        deterministic: speed of the deterministic column, rad/s.
    """

    record: Record
    true: Vector
    statistical: Vector
    deterministic: Vector

    @property
    def crossings(self) -> Vector:
        """Times at which the true speed passes zero, s."""
        return crossing_times(self.record.time, self.true, noise=0.0)

    @property
    def residual(self) -> Vector:
        """Measured minus the estimated wheel, rad/s."""
        return self.record.speed - self.statistical

    @property
    def deterministic_residual(self) -> Vector:
        """Measured minus the deterministic column, rad/s."""
        return self.record.speed - self.deterministic


@dataclass(frozen=True, eq=False)
class Trial:
    """The paper's procedure on one virtual wheel.

    Attributes:
        fit: of profile 2.
        profile1: validation.
        profile2: estimation.
    """

    fit: Fit
    profile1: Prediction
    profile2: Prediction

    @property
    def error(self) -> Vector:
        """Estimate minus truth, (4,) in the order of `NAMES`, SI."""
        return np.array([self.fit.parameters[n] - getattr(STATISTICAL, n) for n in NAMES])

    @property
    def covariance(self) -> Matrix:
        """Formal covariance of the estimate, (4, 4) in the order of `NAMES`, SI."""
        order = [self.fit.names.index(n) for n in NAMES]
        return self.fit.covariance[np.ix_(order, order)]

    @property
    def recovered(self) -> bool:
        """Whether the iteration converged, and to a residual at the level of the noise."""
        return self.fit.converged and at_noise_level(self.profile2.residual)


def at_noise_level(residual: Vector) -> bool:
    """Whether a residual, rad/s, is within 20 % of the tachometer noise."""
    return bool(rms(residual) < 1.2 * SPEED_SIGMA)


def rms(series: Vector) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(series**2)))


def run_trial(seed: int) -> Trial:
    """Record both profiles, estimate from profile 2, predict both."""
    first, second = profile1(seed), profile2(seed)
    fit = estimate(second)
    return Trial(fit, _predict(first, fit), _predict(second, fit))


def run_trials(count: int, say: Say) -> Sequence[Trial]:
    """Run the seeds 0 to `count` - 1.

    Args:
        count: of trials.
        say: told after every tenth part.
    """
    trials = []
    for seed in range(count):
        trials.append(run_trial(seed))
        if (seed + 1) % max(1, count // 10) == 0:
            say(f"  {seed + 1} of {count} records estimated and validated")
    return trials


def _predict(record: Record, fit: Fit) -> Prediction:
    wheels = (STATISTICAL.wheel(), fit.wheel(), DETERMINISTIC.wheel())
    return Prediction(
        record, *(modelled_speed(w, record.time, record.current, 0.0) for w in wheels)
    )
