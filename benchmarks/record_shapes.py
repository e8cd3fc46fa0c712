"""Bench records whose effects have other shapes than those that identification averages over.

An integrator of its own, independent of `gyrostat`: all wheels at once in NumPy, midpoint steps of
1 ms, a wheel that changes sense rests for the remainder of the step. Currents may step between
samples. Truth is dispersed as in `bench_wheels.py`; inertia and current scale are exact.
"""

from dataclasses import dataclass

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.telemetry import Record

INERTIA, STRIBECK_SPEED, STEP = 1.5e-3, 0.4189, 1e-3
NAMES = ("motor_constant", "viscous", "coulomb", "static")


@dataclass(frozen=True)
class Shapes:
    """What a record contains beside the friction model.

    Attributes:
        rate: Samples per second.
        duration: Length of the record, s.
        speed_sigma: Noise of the tachometer before quantisation, rad/s.
        current_noise: Noise of the recorded current before quantisation, A.
        current_quantum: Step of the recorded current, A; 0: none.
        speed_quantum: Step of the recorded speed, rad/s; 0: none.
        between: Whether the current steps at any time, not at samples.
        repeated: Whether the same two currents repeat.
        smooth: Whether the current is a sum of sines instead of steps.
        cogging: Amplitude of each of the harmonics, fraction of the Coulomb torque.
        orders: Harmonics of the wheel's angle.
        eccentricity: Once-per-turn error of the encoder's speed, fraction.
        offset: Largest error of the current sensor, which drifts, A.
        viscous_drift: Amplitude of a sine of the viscous coefficient, fraction.
        dry_drift: Amplitude of the same sine of the dry friction, fraction.
        periods: Periods of this sine in the record.
        jump: Change of the dry friction at a random time, fraction.
        bursts: Change of the dry friction in random intervals of 5 s on average, fraction.
        warming: Viscous friction at the start above that at the end, fraction; it decreases
            exponentially, in a quarter of the record to 1/e.
        asymmetry: Part of the dry friction that acts in one sense, fraction.
        lag: Time constant of the tachometer, s.
    """

    rate: float = 10.0
    duration: float = 300.0
    speed_sigma: float = 5.0 * RPM
    current_noise: float = 0.0
    current_quantum: float = 0.0
    speed_quantum: float = 0.0
    between: bool = False
    repeated: bool = False
    smooth: bool = False
    cogging: float = 0.0
    orders: tuple[int, ...] = (1, 4, 6, 12)
    eccentricity: float = 0.0
    offset: float = 0.0
    viscous_drift: float = 0.0
    dry_drift: float = 0.0
    periods: float = 1.5
    jump: float = 0.0
    bursts: float = 0.0
    warming: float = 0.0
    asymmetry: float = 0.0
    lag: float = 0.0


QUANTA = {"current_quantum": 1e-3, "speed_quantum": 0.4 * RPM}
CASES = {
    "noise": Shapes(),
    "quantised": Shapes(speed_sigma=0.2 * RPM, **QUANTA),
    "quantised-bare": Shapes(speed_sigma=0.0, **QUANTA),
    "quantised-repeated": Shapes(speed_sigma=0.2 * RPM, repeated=True, **QUANTA),
    "quantised-noisy": Shapes(speed_sigma=0.2 * RPM, current_noise=1e-3, **QUANTA),
    "quantised-sines": Shapes(speed_sigma=0.2 * RPM, smooth=True, **QUANTA),
    "1Hz": Shapes(rate=1.0),
    "0.2Hz": Shapes(rate=0.2, duration=900.0),
    "0.2Hz-steps": Shapes(rate=0.2, duration=900.0, between=True),
    "1Hz-steps": Shapes(rate=1.0, between=True),
    "cogging": Shapes(cogging=0.05),
    "eccentricity": Shapes(eccentricity=0.01),
    "offset": Shapes(offset=2e-3),
    "sine-drift": Shapes(viscous_drift=0.1, dry_drift=0.05),
    "asymmetry": Shapes(asymmetry=0.05),
    "asymmetry-5Hz": Shapes(asymmetry=0.05, rate=5.0),
    "jump": Shapes(jump=0.05),
    "bursts": Shapes(bursts=0.05),
    "warm-up": Shapes(warming=0.15),
    "all": Shapes(
        cogging=0.05, eccentricity=0.005, offset=1e-3, viscous_drift=0.1, dry_drift=0.03, lag=0.05
    ),
}


def simulate(
    seed: int | list[int], count: int, shapes: Shapes
) -> list[tuple[Record, dict[str, float]]]:
    """Records of wheels with dispersed parameters, and the true parameters.

    A parameter that drifts has its mean over the record.

    Args:
        seed: Of all random numbers.
        count: Number of records.
        shapes: Contents of the records.
    """
    random = np.random.default_rng(seed)
    motor = 0.0228 * random.uniform(0.8, 1.25, count)
    viscous = 4.83e-6 * random.uniform(0.6, 1.6, count)
    coulomb = 0.8795e-3 * random.uniform(0.7, 1.4, count)
    static = coulomb * random.uniform(1.02, 1.3, count)
    steps = round(shapes.duration / 30.0)
    edges = 30.0 * np.arange(1, steps)[None] * np.ones((count, 1))
    if shapes.between:
        edges = edges + random.uniform(-10.0, 10.0, edges.shape)
    levels = random.uniform(1.55, 3.9, (count, steps))
    if shapes.repeated:
        levels = levels[:, np.arange(steps) // 2 % 2]
    levels = levels * (-1.0) ** np.arange(steps)
    turn = random.uniform(0.0, 2.0 * np.pi, (count, 16))
    unit, lanes = coulomb / motor, np.arange(count)

    def current_at(t: float) -> np.ndarray:
        if shapes.smooth:
            waves = 2.2 * np.sin(2.0 * np.pi * t / 47.0 + turn[:, 0])
            return unit * (waves + 1.4 * np.sin(2.0 * np.pi * t / 19.0 + turn[:, 1]))
        return unit * levels[lanes, np.sum(edges <= t + 1e-9, axis=1)]

    interval = round(1.0 / (shapes.rate * STEP))
    samples = round(shapes.duration * shapes.rate) + 1
    damping_at, dry_at = drifts(random, shapes, np.arange(samples) / shapes.rate, turn[:, 2])
    decay = np.exp(-STEP / shapes.lag) if shapes.lag > 0.0 else 0.0
    speed, angle, shown = np.zeros((3, count))
    speeds, currents = np.zeros((2, samples, count))
    for k in range(samples):
        seen = shown if shapes.lag > 0.0 else speed
        speeds[k] = seen * (1.0 + shapes.eccentricity * np.cos(angle + turn[:, 3]))
        start = k * interval * STEP
        share = start / shapes.duration
        error = shapes.offset * np.sin(np.pi * share + turn[:, 4])
        currents[k] = current_at(start) - error
        if k == samples - 1:
            break
        damping, dry = viscous * damping_at[k], dry_at[k]
        load = motor * current_at(start)
        moving = shapes.between or shapes.smooth
        for j in range(interval):
            if moving and (shapes.smooth or j % 10 == 0):
                load = motor * current_at(start + j * STEP)
            drive = load
            if shapes.cogging:
                waves = [np.sin(n * angle + turn[:, 5 + i]) for i, n in enumerate(shapes.orders)]
                drive = load + shapes.cogging * coulomb * np.sum(waves, axis=0)
            still = speed == 0.0
            sense = np.where(still, np.sign(drive), np.sign(speed))
            level = dry * (1.0 + sense * shapes.asymmetry)
            for part in (0.5, 1.0):
                at = speed if part < 1.0 else end
                bend = np.exp(-((at / STRIBECK_SPEED) ** 2))
                dry_torque = sense * level * (coulomb + (static - coulomb) * bend)
                end = speed + part * STEP * (drive - dry_torque - damping * at) / INERTIA
            rests = still & (np.abs(drive) <= level * static)
            end = np.where(rests | (end * sense < 0.0), 0.0, end)
            middle = 0.5 * (speed + end)
            angle, speed = angle + STEP * middle, end
            shown = middle + (shown - middle) * decay
    speeds += shapes.speed_sigma * random.standard_normal(speeds.shape)
    currents += shapes.current_noise * random.standard_normal(currents.shape)
    if shapes.current_quantum:
        currents = shapes.current_quantum * np.round(currents / shapes.current_quantum)
    if shapes.speed_quantum:
        speeds = shapes.speed_quantum * np.round(speeds / shapes.speed_quantum)
    times = np.arange(samples) / shapes.rate
    truth = np.column_stack([motor, viscous, coulomb, static])
    return [
        (
            Record(f"{seed}-{k}", times, currents[:, k], speeds[:, k], times >= 0.0),
            dict(zip(NAMES, truth[k].tolist(), strict=True)),
        )
        for k in range(count)
    ]


def drifts(
    random: np.random.Generator, shapes: Shapes, times: np.ndarray, phase: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Viscous and dry friction over their means at each time, (samples, wheels) each.

    Args:
        random: Random numbers.
        shapes: Contents of the records.
        times: Times of the samples, s.
        phase: Phase of the sine of each wheel, rad.
    """
    share = times[:, None] / shapes.duration
    sine = np.sin(2.0 * np.pi * shapes.periods * share + phase)
    viscous = shapes.viscous_drift * sine + shapes.warming * np.exp(-4.0 * share)
    dry = shapes.dry_drift * sine
    if shapes.jump:
        dry = dry + shapes.jump * (share > random.uniform(0.2, 0.8, phase.shape))
    if shapes.bursts:
        changes = random.random(sine.shape) < 1.0 / (5.0 * shapes.rate)
        dry = dry + shapes.bursts * (np.cumsum(changes, axis=0) % 2)
    return 1.0 + viscous - np.mean(viscous, axis=0), 1.0 + dry - np.mean(dry, axis=0)
