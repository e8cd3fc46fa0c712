"""Intervals of the monitor for slews of several shapes and telemetry at 1 to 10 s.

    python benchmarks/monitor_slews.py [--flights 100] [--first 2000]

Flights of `monitor_bursts.py` without bursts, known from a data sheet, with other slews, which move
the speed of the wheel by up to 30 rad/s. Half of the flights have a sample of the current that is
a mean of two seconds, with a weight drawn for each. Prints valid windows, share of 95 % intervals
that hold the true value and rms of the error over sigma.
"""

import numpy as np
from monitor_bursts import BODY, DURATION, INERTIA, PARAMETERS, asked, fly, judged, scores

RISE = 30.0
"""Largest change of the speed of the wheel from its mean, rad/s."""


def sine(period):
    """Sines without a pause."""
    phase = 2.0 * np.pi * np.arange(DURATION) / period
    return RISE * 2.0 * np.pi / period * np.sin(phase)


def bang_bang(period):
    """Full acceleration one way and the other, without a pause."""
    return RISE * 4.0 / period * np.sign(np.sin(2.0 * np.pi * np.arange(DURATION) / period))


def coast(period):
    """40 s of acceleration, 200 s of coasting and 40 s of deceleration, one way and the other."""
    phase, way = np.arange(DURATION) % period, np.arange(DURATION) // period % 2
    pulse = 1.0 * (phase < 40) - ((phase >= 240) & (phase < 280))
    return RISE / 40.0 * pulse * np.where(way == 0, 1.0, -1.0)


SHAPES = {
    "sine, 313 s": sine(313),
    "sine, 617 s": sine(617),
    "bang-bang, 701 s": bang_bang(701),
    "bang-bang, 3000 s": bang_bang(3000),
    "40 s, coast, 40 s": coast(1501),
}


def main():
    """Print the table."""
    numbers = asked(__doc__, 2000)
    print("| slews | telemetry | valid | inside 95 %, rms score:", *PARAMETERS)
    weights = np.random.default_rng(numbers.start).uniform(-1.0, 1.0, len(numbers)).clip(0)
    for shape, change in SHAPES.items():
        wanted = change * INERTIA / BODY
        flights = fly(numbers, "sheet", bursts=False, wanted=wanted, mixed=weights)
        for period in (1, 5, 10):
            said = [shape, f"{period} s", *judged(scores(flights, "sheet", period))]
            print(f"| {' | '.join(said)} |", flush=True)


if __name__ == "__main__":
    main()
