"""Intervals of the monitor with a current that is rounded with little noise.

    python benchmarks/monitor_rounding.py [--flights 100] [--first 5000]

Flights of `monitor_bursts.py` without bursts, known from a data sheet, with slews that move the
speed of the wheel by up to 30 rad/s. Prints valid windows, share of 95 % intervals that hold the
true value and rms of the error over sigma.
"""

import numpy as np
from monitor_bursts import BODY, DURATION, INERTIA, PARAMETERS, asked, fly, judged, scores, slews
from monitor_slews import RISE, sine

ROUNDED = [(step, dither) for step in (1e-3, 5e-3) for dither in (0.0, 0.2)]
"""Steps of the current, A, and noise before rounding over the step."""


def short():
    """20 s of acceleration, one way and the other, each 15 minutes."""
    phase, way = np.arange(DURATION) % 900, np.arange(DURATION) // 900 % 2
    return RISE / 20.0 * (phase < 20) * np.where(way == 0, 1.0, -1.0)


SHAPES = {
    "20 s, each 15 min": short() * INERTIA / BODY,
    "smooth, 400 s": slews(),
    "sine, 617 s": sine(617) * INERTIA / BODY,
    "none": np.zeros(DURATION),
}


def main():
    """Print the table."""
    numbers = asked(__doc__, 5000)
    print("| slews | step | noise | valid | inside 95 %, rms score:", *PARAMETERS)
    for shape, wanted in SHAPES.items():
        for step, dither in ROUNDED:
            rounded = (step, dither)
            flights = fly(numbers, "sheet", bursts=False, wanted=wanted, rounded=rounded)
            said = [shape, f"{1e3 * step:.0f} mA", f"{dither:.1f}"]
            said += judged(scores(flights, "sheet"))
            print(f"| {' | '.join(said)} |", flush=True)


if __name__ == "__main__":
    main()
