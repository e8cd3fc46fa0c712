"""Simulated waterfall of a wheel on a force platform: equations of motion over time, then spectra.

The rotor of each mode is integrated in time, exactly for noise that is white and for tones; the
spectra are those of `scipy.signal.welch`. Nothing of the fit is used, so that simulations test it.
"""

from typing import Any

import numpy as np
from scipy.signal import lfilter, welch

from gyrostat.core.types import Vector
from gyrostat.microvibration.model import KINDS, Mode, WheelDisturbance
from gyrostat.microvibration.waterfall import Waterfall, Window

DECAY = 6.0
"""Time constants of the mode that pass before the record begins."""


def simulated_waterfall(
    disturbance: WheelDisturbance,
    speed: Vector,
    generator: np.random.Generator,
    *,
    rate: float = 2000.0,
    duration: float = 16.0,
    segment: float = 2.0,
    highest: float = 400.0,
    floor: dict[str, float] | None = None,
) -> Waterfall:
    """Simulate the measurement of a waterfall.

    Args:
        disturbance: Loads of the wheel.
        speed: Wheel speeds, (S,), rad/s.
        generator: Source of random numbers.
        rate: Samples per second, Hz.
        duration: Time at each speed, s.
        segment: Length of the segments of the spectra, s.
        highest: Highest frequency, Hz.
        floor: Kind of load -> density of the noise of the platform; its kinds are measured.
    """
    floor = dict.fromkeys(KINDS, 0.0) if floor is None else floor
    rows: dict[str, list[Vector]] = {load: [] for kind in floor for load in KINDS[kind]}
    frequency = np.zeros(0)
    for each in speed:
        for kind, noise in floor.items():
            load = _load(disturbance, kind, float(each), rate, duration, generator)
            for name, signal in zip(KINDS[kind], (load.real, load.imag), strict=False):
                signal = signal + generator.normal(0.0, np.sqrt(0.5 * noise * rate), len(signal))
                frequency, density = welch(signal, rate, nperseg=round(segment * rate))
                rows[name].append(density)
    # the mean of a segment is removed, which the window spreads over the first bins
    shown = (frequency <= highest) & (frequency >= 3.0 / segment)
    densities = {load: np.array(values)[:, shown] for load, values in rows.items()}
    window = Window.named("hann")
    return Waterfall(f"simulated {disturbance.name}", speed, frequency[shown], densities, window)


def _load(
    disturbance: WheelDisturbance,
    kind: str,
    speed: float,
    rate: float,
    duration: float,
    generator: np.random.Generator,
) -> Any:
    """Load on the mount as a complex number, x + iy, (N,)."""
    mode = disturbance.modes.get(kind)
    before = 0.0 if mode is None else DECAY / (mode.damping * mode.frequency)
    time = np.arange(-round(before * rate), round(duration * rate)) / rate
    tones = []
    for each in disturbance.harmonics:
        for sense, values in ((1.0, each.forward), (-1.0, each.backward)):
            if kind in values:
                phase = np.exp(2j * np.pi * generator.random())
                tones.append((sense * each.number * speed, values[kind] * speed**2 * phase))
    noise = disturbance.noise.get(kind)
    density = 0.0 if noise is None else float(noise.at(speed))
    if mode is None:
        total = np.sqrt(0.5 * density * rate) * _normal(generator, len(time))
        for frequency, amplitude in tones:
            total = total + amplitude * np.exp(1j * frequency * time)
    else:
        total = _through(mode, speed, time, tones, density, generator)
    return total[time >= 0.0]


def _through(
    mode: Mode,
    speed: float,
    time: Vector,
    tones: list[tuple[float, Any]],
    density: float,
    generator: np.random.Generator,
) -> Any:
    """Transmitted load of a rotor, q'' + (2 z n - i g W) q' + n² q = load."""
    n, step = mode.frequency, time[1] - time[0]
    drag = 2.0 * mode.damping * n
    poles = np.roots([1.0, drag - 1j * mode.inertia_ratio * speed, n**2])
    inputs = np.linalg.solve(np.array([[1.0, 1.0], poles]), np.array([0.0, 1.0]))
    sums = poles[:, None] + poles.conj()
    outer = np.outer(inputs, inputs.conj())
    covariance = density * outer * (np.exp(sums * step) - 1.0) / sums
    root = np.linalg.cholesky(covariance) if density > 0.0 else 0.0 * covariance
    # both axes of the load have the one-sided density, so that x + iy has it two-sided
    forcing = root @ (_normal(generator, 2 * len(time)).reshape(2, -1) / np.sqrt(2.0))
    for frequency, amplitude in tones:
        push = inputs * (np.exp(1j * frequency * step) - np.exp(poles * step))
        push = amplitude * push / (1j * frequency - poles)
        forcing = forcing + push[:, None] * np.exp(1j * frequency * (time - step))
    parts = [
        lfilter([1.0], [1.0, -np.exp(pole * step)], row)
        for pole, row in zip(poles, forcing, strict=True)
    ]
    return (drag * poles + n**2) @ np.array(parts)


def _normal(generator: np.random.Generator, count: int) -> Any:
    """Complex numbers whose real and imaginary parts have the variance 1, (count,)."""
    return generator.standard_normal(count) + 1j * generator.standard_normal(count)
