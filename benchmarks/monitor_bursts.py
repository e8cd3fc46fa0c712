"""Intervals of the monitor under torque bursts and slow attitude loops, without body rates.

    python benchmarks/monitor_bursts.py [--flights 100] [--first 1000]

A body about one axis with one wheel and an attitude loop of 0.02 to 0.3 rad/s, half a day at 1 Hz,
speeds rounded to 0.4 rpm and currents to 1 mA. Half of the flights have a slew each 25 minutes,
half of them friction noise of 0.5 %, the others 2 %. Prints, without and with bursts of 20 s to
30 min and 3 to 200 % of the Coulomb torque, and for two kinds of knowledge: valid windows, share of
95 % intervals that hold the true value and rms of the error over sigma.
"""

import argparse
from typing import NamedTuple

import numpy as np

from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

INERTIA, MOTOR, COULOMB, VISCOUS = 1.5e-3, 0.027, 9e-4, 5e-6
BODY = 70.0
DURATION = 43200
CORRELATION = 1200.0
RPM = np.pi / 30.0
KNOWN = {"bench": (0.003, 0.01), "sheet": (0.05, 0.3)}
"""Relative standard deviations of motor constant and viscous friction; the truth is drawn so."""
PARAMETERS = ("motor_constant", "viscous", "coulomb")


class Flights(NamedTuple):
    """Telemetry of some flights, (samples, flights), and their true parameters, (flights,)."""

    speed: np.ndarray
    current: np.ndarray
    truth: tuple[np.ndarray, ...]


def slews():
    """Angular accelerations of smooth slews of 400 s each 25 minutes, (samples,), rad/s²."""
    time = np.arange(DURATION)
    pulse = np.where(time % 3000 < 400, np.sin(2.0 * np.pi * (time % 3000) / 400.0), 0.0)
    return 1e-5 * (pulse - np.roll(pulse, 1500))


def fly(numbers, known, *, bursts, wanted, mixed=0.0, rounded=(1e-3, 0.5)):
    """Fly some numbers.

    `wanted` are angular accelerations of slews, (samples,). A sample of the current contains that
    of the second before with the weight `mixed`. `rounded` are the step of the current, A, and the
    noise before rounding, a share of it.
    """
    count = len(numbers)
    sigma_motor, sigma_viscous = KNOWN[known]
    random = [
        np.random.default_rng([n, bursts, bool(wanted.any()), *known.encode()]) for n in numbers
    ]
    draws = np.array([r.standard_normal(4) for r in random]).T
    motor = MOTOR * (1.0 + sigma_motor * draws[0])
    viscous = VISCOUS * (1.0 + sigma_viscous * draws[1]).clip(0.1)
    coulomb = COULOMB * np.exp(0.1 * draws[2])
    noise = np.array([r.choice([0.005, 0.02]) for r in random])
    bandwidth = np.array([r.choice([0.02, 0.05, 0.1, 0.3]) for r in random])
    height = np.array([_heights(r) if bursts else np.zeros(DURATION) for r in random]).T
    keep = np.exp(-1.0 / CORRELATION)
    shocks = np.array([r.standard_normal(DURATION) for r in random]).T
    shocks *= noise * coulomb * np.sqrt(1.0 - keep**2)
    phase = np.array([r.uniform(0.0, 2.0 * np.pi) for r in random])
    slow = noise * coulomb * draws[3]
    angle, rate, gained, wheel = np.zeros((4, count))
    wheel = wheel + 150.0
    speed, current, friction = np.zeros((3, DURATION, count))
    for k in range(DURATION):
        slow = keep * slow + shocks[k]
        friction[k] = coulomb * (1.0 + height[k]) + slow
        feedback = BODY * bandwidth * (bandwidth * angle + 1.4 * rate)
        asked = feedback - BODY * wanted[k] + COULOMB + VISCOUS * wheel
        # the viscous torque of the mean speed of the step
        net = motor * asked / MOTOR - friction[k] - viscous * (wheel + 0.5 * gained)
        speed[k], current[k] = wheel, asked / MOTOR
        outside = 2e-6 * np.sin(2.0 * np.pi * k / 5700.0 + phase)
        rate = rate + (outside - net) / BODY - wanted[k]
        angle = angle + rate
        gained = net / INERTIA
        wheel = wheel + gained
    current[1:] = (1.0 - mixed) * current[1:] + mixed * current[:-1]
    noises = np.array([r.standard_normal((2, DURATION)) for r in random]).transpose(1, 2, 0)
    speed = np.round(speed / (0.4 * RPM) + 0.2 * noises[0]) * 0.4 * RPM
    step, dither = rounded
    current = np.round(current / step + dither * noises[1]) * step
    return Flights(speed, current, (motor, viscous, friction.mean(axis=0)))


def _heights(random):
    """Height of bursts over the Coulomb torque at each sample of a flight."""
    height = np.zeros(DURATION)
    typical = np.exp(random.uniform(np.log(0.03), np.log(2.0)))
    k = int(random.exponential(3000.0))
    while k < DURATION:
        length = int(random.choice([20, 60, 150, 300, 900, 1800]) * random.uniform(0.5, 1.5))
        height[k : k + length] = typical * random.uniform(0.5, 1.5)
        k += length + int(random.exponential(3000.0))
    return height


def scores(flights, known, period=1):
    """Errors over sigma of the valid windows, (windows, 3), with a sample each `period` seconds."""
    motor, viscous = KNOWN[known]
    sigma = {"motor_constant": motor * MOTOR, "viscous": viscous * VISCOUS, "offset": 1e-9}
    wheel = KnownWheel("a", INERTIA, MOTOR, COULOMB, VISCOUS, stribeck_speed=0.5, sigma=sigma)
    wheels = KnownWheels((wheel,), speed_resolution=0.4 * RPM)
    found = []
    for k in range(flights.speed.shape[1]):
        monitor = WheelMonitor(wheels, window=float(DURATION))
        time = np.arange(0.0, DURATION, period)
        seen = (each[::period, k : k + 1] for each in (flights.speed, flights.current))
        monitor.add(Samples(time, *seen))
        table = monitor.windows()
        right = [values[k] for values in flights.truth]
        if table["valid"][0]:
            pairs = zip(PARAMETERS, right, strict=True)
            found.append([(table[n][0] - true) / table[f"{n}_sigma"][0] for n, true in pairs])
    return np.array(found).reshape(-1, 3)


def asked(description, first):
    """Numbers of the flights that the command line asks for."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--flights", type=int, default=100)
    parser.add_argument("--first", type=int, default=first)
    arguments = parser.parse_args()
    return range(arguments.first, arguments.first + arguments.flights)


def main():
    """Print the table."""
    numbers = asked(__doc__, 1000)
    print("| pointing | bursts | known from | valid | inside 95 %, rms score:", *PARAMETERS)
    for pointing, wanted in {"quiet": np.zeros(DURATION), "slews": slews()}.items():
        for bursts in (False, True):
            for known in KNOWN:
                score = scores(fly(numbers, known, bursts=bursts, wanted=wanted), known)
                said = [pointing, "yes" if bursts else "no", known, *judged(score)]
                print(f"| {' | '.join(said)} |", flush=True)


def judged(score):
    """Number of windows, and for each parameter the share inside 95 % and the rms score."""
    inside = np.mean(np.abs(score) < 1.959964, axis=0)
    rms = np.sqrt(np.mean(score**2, axis=0))
    cells = zip(inside, rms, strict=True)
    return [str(len(score)), *(f"{100.0 * i:.0f} %, {r:.2f}" for i, r in cells)]


if __name__ == "__main__":
    main()
