"""The paper's two experiments on a virtual wheel: record, estimate, predict."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gyrostat.core.jax64 import jax
from gyrostat.core.types import Matrix, Vector
from gyrostat.identification import Fit, identify
from gyrostat.identification.read.statistics import crossing_times
from gyrostat.papers.carrara_kuga import setup
from gyrostat.papers.reproduction import Run
from gyrostat.simulation import CurrentRange, Telemetry, bench_record
from gyrostat.telemetry import Record
from gyrostat.wheel import Wheel, speed_response

RECORDS, QUICK_RECORDS = 200, 12
"""Number of virtual records of profile 2, each with a record of profile 1."""
PROFILE1_SEEDS = 1_000_000
"""Offset of the seed for profile 1, so that its noise differs from that of profile 2."""
HALVINGS = 60
"""Number of bisections of an interval: to the last bit."""

_respond = jax.jit(speed_response)


def modelled_speed(wheel: Wheel, time: Vector, current: Vector, initial_speed: float) -> Vector:
    """Speed of a wheel with current held between samples, rad/s.

    Args:
        wheel: Wheel model.
        time: Time, (N,), s.
        current: Current, (N,), A.
        initial_speed: Initial speed, rad/s.
    """
    speed, resolved = _respond(wheel, time, current, initial_speed)
    assert bool(resolved)  # true for every curve at these sample rates
    return np.asarray(speed)


def breakaway_current(wheel: Wheel) -> float:
    """Smallest constant current at which the wheel leaves rest within a second, A."""

    def leaves(current: float) -> bool:
        currents = np.array([current, current])
        return bool(modelled_speed(wheel, np.array([0.0, 1.0]), currents, 0.0)[-1] != 0.0)

    return _threshold(leaves, 0.0, 1.0)


def stop_time(wheel: Wheel, initial_speed: float) -> float:
    """Time at which a coasting wheel comes to rest, s."""

    def rests(duration: float) -> bool:
        time = np.array([0.0, duration])
        return bool(modelled_speed(wheel, time, np.zeros(2), initial_speed)[-1] == 0.0)

    return _threshold(rests, 0.0, 1000.0)


def _threshold(condition: Callable[[float], bool], low: float, high: float) -> float:
    """Threshold of a condition that is true at `high` and false at `low`."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if condition(middle) else (middle, high)
    return high


def profile1(seed: int) -> Record:
    """Record of sine cycles with random amplitude and period, the paper's validation record."""
    return _record(
        "sines", setup.SINE_CURRENTS, setup.SINE_PERIOD, seed + PROFILE1_SEEDS, "profile 1"
    )


def profile2(seed: int) -> Record:
    """Record of steps with random amplitude, reversed every 30 s, the paper's estimation record."""
    return _record("steps", setup.STEP_CURRENTS, setup.STEP_PERIOD, seed, "profile 2")


def _record(profile: str, amplitudes: CurrentRange, period: float, seed: int, name: str) -> Record:
    return bench_record(
        setup.STATISTICAL.wheel(),
        profile,
        duration=setup.DURATION,
        telemetry=Telemetry(rate=setup.RATE, speed_sigma=setup.SPEED_SIGMA),
        amplitudes=amplitudes,
        period=period,
        seed=seed,
        name=name,
    )


def estimate(record: Record, *, stribeck_speed: float | None = setup.STRIBECK_SPEED) -> Fit:
    """Estimate x2..x5 as in the paper, with known x1(0) = 0.

    Args:
        record: Record to fit.
        stribeck_speed: Held Stribeck speed, rad/s; None to estimate it too.
    """
    hold: dict[str, Any] = {"initial_speed": 0.0}
    if stribeck_speed is not None:
        hold["stribeck_speed"] = stribeck_speed
    return identify(
        record,
        inertia=setup.INERTIA,
        hold=hold,
        free=["stribeck_speed"] if stribeck_speed is None else [],
        prior={
            name: (setup.INERTIA * mean, setup.INERTIA * sigma)
            for name, mean, sigma in zip(setup.NAMES, setup.START, setup.PRIOR_SIGMA, strict=True)
        },
        speed_sigma=setup.SPEED_SIGMA,
        white_noise=True,
    )


@dataclass(frozen=True, eq=False)
class Prediction:
    """Record with the speeds that models predict from its current.

    Attributes:
        record: The record.
        true: Speed of the true wheel, without noise, (N,), rad/s.
        statistical: Speed of the estimated wheel, (N,), rad/s.
        deterministic: Speed with the deterministic column of Table 1, (N,), rad/s.
    """

    record: Record
    true: Vector
    statistical: Vector
    deterministic: Vector

    @property
    def crossings(self) -> int:
        """Number of zero crossings of the true speed."""
        return len(crossing_times(self.record.time, self.true, noise=0.0))

    @property
    def residual(self) -> Vector:
        """Measured speed minus that of the estimated wheel, rad/s."""
        return self.record.speed - self.statistical

    @property
    def deterministic_residual(self) -> Vector:
        """Measured speed minus that of the deterministic column, rad/s."""
        return self.record.speed - self.deterministic


@dataclass(frozen=True, eq=False)
class Trial:
    """Result of the paper's procedure with one virtual wheel.

    Attributes:
        fit: Fit of profile 2.
        profile1: Prediction of the validation record.
        profile2: Prediction of the estimation record.
    """

    fit: Fit
    profile1: Prediction
    profile2: Prediction

    @property
    def error(self) -> Vector:
        """Estimate minus true value, (4,) in the order of `NAMES`, SI."""
        return np.array(
            [self.fit.parameters[n] - getattr(setup.STATISTICAL, n) for n in setup.NAMES]
        )

    @property
    def covariance(self) -> Matrix:
        """Formal covariance of the estimate, (4, 4) in the order of `NAMES`, SI."""
        order = [self.fit.names.index(n) for n in setup.NAMES]
        return self.fit.covariance[np.ix_(order, order)]

    @property
    def recovered(self) -> bool:
        """Whether the iteration converged to a residual within 20 % of the noise."""
        return self.fit.converged and rms(self.profile2.residual) < 1.2 * setup.SPEED_SIGMA


def rms(series: Vector) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(series**2)))


def run_trial(seed: int) -> Trial:
    """Simulate both records, estimate from profile 2 and predict both."""
    validation, estimation = profile1(seed), profile2(seed)
    fit = estimate(estimation)
    return Trial(fit, _predict(validation, fit), _predict(estimation, fit))


def _predict(record: Record, fit: Fit) -> Prediction:
    wheels = (setup.STATISTICAL.wheel(), fit.wheel(), setup.DETERMINISTIC.wheel())
    return Prediction(
        record, *(modelled_speed(w, record.time, record.current, 0.0) for w in wheels)
    )


def trials(run: Run) -> Sequence[Trial]:
    """Trials with seeds 0, 1, ..."""
    count = QUICK_RECORDS if run.quick else RECORDS
    results = []
    for seed in range(count):
        results.append(run_trial(seed))
        if (seed + 1) % max(1, count // 10) == 0:
            run.say(f"{seed + 1} of {count} records estimated and validated")
    return results
