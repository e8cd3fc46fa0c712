"""Virtual bench: simulated test bench records of a known wheel."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.core.validation import check_seed, require_period
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import rounded
from gyrostat.wheel import Wheel, speed_response
from gyrostat.wheel.friction import static_curve

MOST_SAMPLES = 2_000_000
"""Largest number of samples in a record; the same as in `gyrostat.telemetry.read_record`."""
BYTES_A_SAMPLE = 72
"""Peak memory per sample, bytes: time, current, speed, noise and validity, and their copies."""


@dataclass(frozen=True)
class CurrentRange:
    """Range of the amplitudes of a commanded current.

    Attributes:
        low: Smallest amplitude, A.
        high: Largest amplitude, A.
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        """Validate the range; raises `InputError`."""
        if not 0.0 <= self.low <= self.high < np.inf:
            raise InputError(
                f"current range: found {self.low:g} to {self.high:g} A, expected 0 <= low <= high"
            )

    def draw(self, random: np.random.Generator, count: int) -> Vector:
        """Draw uniformly distributed amplitudes, (count,), A."""
        return random.uniform(self.low, self.high, count)


def default_range(wheel: Wheel) -> CurrentRange:
    """Amplitudes for rotation at low speed: 1.5 to 4 times the breakaway current of the wheel."""
    levels = [static_curve(wheel.friction).breakaway_torque(sense) for sense in (1.0, -1.0)]
    breakaway = float(max(levels)) / abs(float(wheel.motor_constant))
    return CurrentRange(1.5 * breakaway, 4.0 * breakaway)


def steps(
    time: Vector, amplitudes: CurrentRange, random: np.random.Generator, period: float = 30.0
) -> Vector:
    """Constant currents of random amplitude and alternating sign, A.

    Profile 2 of Carrara and Kuga: a step every 30 s.

    Args:
        time: Sample times, (N,), s, from zero.
        amplitudes: Range of the amplitudes.
        random: Random generator of the amplitudes.
        period: Duration of one step, s.
    """
    # sample times are rounded: with the tolerance, the sample at which a step starts is in it
    step = np.floor(time / period + 1e-9).astype(int)
    # a last sample at the end of a step starts no new step: its current would have no effect
    step[-1] = step[-2]
    signed = amplitudes.draw(random, step[-1] + 1) * (-1.0) ** np.arange(step[-1] + 1)
    return signed[step]


def sines(
    time: Vector, amplitudes: CurrentRange, random: np.random.Generator, period: float = 24.0
) -> Vector:
    """Sine cycles, each with a random amplitude and a random period within 25 % of the mean, A.

    Profile 1 of Carrara and Kuga. The periods are scaled to fill the record with whole half cycles.

    Args:
        time: Sample times, (N,), s, from zero.
        amplitudes: Range of the amplitudes.
        random: Random generator of amplitudes and periods.
        period: Mean period, s.
    """
    halves = max(1, round(2.0 * time[-1] / period))
    cycles = -(-halves // 2)
    lengths = random.uniform(0.75, 1.25, cycles)
    lengths *= time[-1] / (lengths.sum() - 0.5 * (halves % 2) * lengths[-1])
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    cycle = np.clip(np.searchsorted(starts, time, side="right") - 1, 0, cycles - 1)
    phase = (time - starts[cycle]) / lengths[cycle]
    return amplitudes.draw(random, cycles)[cycle] * np.sin(2.0 * np.pi * phase)


def ramps(
    time: Vector, amplitudes: CurrentRange, random: np.random.Generator, period: float = 60.0
) -> Vector:
    """Slow ramps from zero current, alternating in sign, each followed by a coast to rest, A.

    The current at which the wheel breaks away is the static torque over the motor constant.

    Args:
        time: Sample times, (N,), s, from zero.
        amplitudes: Range of the peak currents.
        random: Random generator of the peaks.
        period: Duration of one ramp with its coast, s; the ramp takes half of it.
    """
    step = np.floor(time / period + 1e-9).astype(int)
    peaks = amplitudes.draw(random, step[-1] + 1) * (-1.0) ** np.arange(step[-1] + 1)
    share = 2.0 * (time / period - step)
    return np.where(share < 1.0, peaks[step] * share, 0.0)


PROFILES: dict[str, Callable[..., Vector]] = {"steps": steps, "sines": sines, "ramps": ramps}
"""Current profiles by name."""


@dataclass(frozen=True)
class Telemetry:
    """Sampling, noise and dropouts of a bench record.

    Attributes:
        rate: Sampling rate, Hz.
        speed_sigma: Standard deviation of the white noise of the tachometer, rad/s.
        speed_quantum: Quantisation step of the tachometer, rad/s; zero for none.
        jitter: Standard deviation of the sample times, as a fraction of the sample interval.
        dropouts: Fraction of speed samples that are missing.
    """

    rate: float = 10.0
    speed_sigma: float = 0.0
    speed_quantum: float = 0.0
    jitter: float = 0.0
    dropouts: float = 0.0

    def __post_init__(self) -> None:
        """Validate the values; raises `InputError`."""
        for name, low, high in (
            ("rate", 1e-9, 1e6),
            ("speed_sigma", 0.0, np.inf),
            ("speed_quantum", 0.0, np.inf),
            ("jitter", 0.0, 0.3),
            ("dropouts", 0.0, 0.9),
        ):
            value = getattr(self, name)
            if not (np.isfinite(value) and low <= value <= high):
                raise InputError(f"{name}: found {value:g}, expected {low:g} to {high:g}")

    def sample_times(self, duration: float, random: np.random.Generator) -> Vector:
        """Sample times, s, strictly increasing, from zero up to `duration`."""
        count = int(np.floor(duration * self.rate * (1.0 + 1e-12))) + 1
        # a shift below half an interval keeps the order of the samples
        shift = np.clip(self.jitter * random.standard_normal(count), -0.45, 0.45)
        shift[0] = 0.0
        return (np.arange(count) + shift) / self.rate


def bench_record(
    wheel: Wheel,
    profile: str,
    *,
    duration: float,
    telemetry: Telemetry,
    amplitudes: CurrentRange | None = None,
    initial_speed: float = 0.0,
    period: float | None = None,
    seed: int = 0,
    name: str = "bench",
) -> Record:
    """Record a wheel on the virtual bench.

    The drive holds each commanded current until the next sample.

    Args:
        wheel: True wheel.
        profile: Current profile: "steps", "sines" or "ramps".
        duration: Duration of the record, s.
        telemetry: Sampling and noise.
        amplitudes: Range of the current amplitudes, A; by default from the breakaway current.
        initial_speed: Initial wheel speed, rad/s.
        period: Period of the profile, s; each profile has its own default.
        seed: Seed of profile and noise; the same seed gives the same record.
        name: Name of the record.

    Raises:
        InputError: An unknown profile, too short a duration, a period that is out of range, or
            impossible parameters of the wheel.
    """
    if profile not in PROFILES:
        raise InputError(f"profile: found {profile!r}, expected one of {', '.join(PROFILES)}")
    if not (np.isfinite(duration) and duration * telemetry.rate >= 1.0):
        raise InputError(f"duration: found {duration:g} s, expected at least one sample interval")
    wheel.check()
    samples = duration * telemetry.rate
    if samples > MOST_SAMPLES:
        size = MOST_SAMPLES * BYTES_A_SAMPLE / 1e9
        raise InputError(
            f"duration: found {duration:g} s at {telemetry.rate:g} Hz, {samples:.3g} samples, "
            f"expected at most {MOST_SAMPLES} ({size:.2g} GB in memory), the limit of a record"
        )
    if period is not None:
        require_period("period", period)
        if period * telemetry.rate < 1.0:
            raise InputError(f"period: found {period:g} s, expected at least one sample interval")
    check_seed(seed)
    streams = np.random.SeedSequence(seed).spawn(2)
    command_random, noise_random = map(np.random.default_rng, streams)
    time = telemetry.sample_times(duration, noise_random)
    shape = {} if period is None else {"period": period}
    current = PROFILES[profile](time, amplitudes or default_range(wheel), command_random, **shape)
    speed, resolved = jax.jit(speed_response)(
        wheel, jnp.asarray(time), jnp.asarray(current), initial_speed
    )
    if not bool(resolved):
        raise InputError(
            f"rate: found {telemetry.rate:g} Hz, expected a higher rate for this friction curve"
        )
    reading = np.asarray(speed) + telemetry.speed_sigma * noise_random.standard_normal(len(time))
    reading = rounded(reading, telemetry.speed_quantum)
    valid = noise_random.random(len(time)) >= telemetry.dropouts
    return Record(
        name=name,
        time=time,
        current=current,
        speed=np.where(valid, reading, np.nan),
        valid=valid,
    )
