"""Let Basilisk's wheels coast and draw the figure of docs/wheels_that_stop.md.

    python docs/make_wheels_that_stop.py PYTHON

PYTHON is an interpreter that has Basilisk (package bsk). The rows of the page's table are printed.
"""

import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.units import RPM
from gyrostat.reports.colours import MARK, MODEL
from gyrostat.reports.drawing import STYLE
from gyrostat.wheel import Wheel, read_wheel_sheet, speed_response

ROOT = Path(__file__).parents[1]
SHIPPED = {"BCT_RWP015": "bct-rwp015", "NanoAvionics_RW0": "nanoavionics-rw0"}
SPEED = 100.0 * RPM
STEPS = (0.01, 0.1, 0.5)
HOUR = 3600.0


def rows(basilisk):
    """The table: what is left of the speed an hour later, and how far the wheel turns in it."""
    for kind, name in SHIPPED.items():
        sheet = read_wheel_sheet(name).values
        cells = [f"{sheet['inertia'] * SPEED / sheet['coulomb']:.3f}"]
        for step in STEPS:
            run = {"kind": kind, "speed": SPEED, "settings": {}}
            _, found = basilisk.ask("coast", [run], step=step, duration=HOUR, every=HOUR)
            left = found[0][-1]
            cells.append(f"{left:.4f} rad/s, {abs(left) * HOUR / (2.0 * np.pi):.0f} turns")
        print(f"| `{kind}` | {' | '.join(cells)} |")


def figure(basilisk, step=0.1, duration=10.0):
    """Speeds of the two wheels around the time at which they must stop."""
    drawn = Figure(figsize=(6.4, 2.9), layout="constrained")
    time = np.arange(0.0, duration + 0.5 * step, step)
    for axes, (kind, name) in zip(drawn.subplots(1, 2, sharey=True), SHIPPED.items(), strict=True):
        sheet = read_wheel_sheet(name)
        stop = sheet.values["inertia"] * SPEED / sheet.values["coulomb"]
        run = {"kind": kind, "speed": SPEED, "settings": {}}
        _, found = basilisk.ask("coast", [run], step=step, duration=duration, every=step)
        wheel = Wheel(sheet.values["inertia"], 1.0, sheet.friction())
        ours, _ = speed_response(wheel, time, np.zeros_like(time), SPEED)
        axes.axvline(stop, color="#6b7077", lw=0.8, ls=":")
        axes.plot(time, found[0], color=MARK, lw=1.2, label="Basilisk")
        axes.plot(time, ours, color=MODEL, lw=1.2, label="gyrostat")
        axes.set(title=kind, xlabel="time, s", xlim=(stop - 0.5, stop + 2.0), ylim=(-0.15, 0.4))
    axes.legend(loc="upper right")
    drawn.axes[0].set_ylabel("wheel speed, rad/s")
    return drawn


def main():
    """Measure, print and draw."""
    if len(sys.argv) != 2:
        raise SystemExit("found no interpreter, expected one that has Basilisk: see the docstring")
    sys.path.insert(0, str(ROOT / "benchmarks"))
    from ask_basilisk import Basilisk

    basilisk = Basilisk(sys.argv[1])
    print(f"Basilisk {basilisk.version}")
    rows(basilisk)
    with mpl.rc_context(STYLE):
        figure(basilisk).savefig(
            ROOT / "docs" / "images" / "wheels_that_stop.png", dpi=110, metadata={"Software": None}
        )


if __name__ == "__main__":
    main()
