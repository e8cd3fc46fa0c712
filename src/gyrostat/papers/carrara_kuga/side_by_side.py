"""One crossing under every controller, noise and wrong model included."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat._types import Vector
from gyrostat.papers.carrara_kuga.dispersed import CONTENDERS, DURATION, Contender, Known
from gyrostat.papers.carrara_kuga.table import TABLE_INERTIA, WHEEL, TableRun, fly, scaled
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import STYLE

WRONG = Known(
    friction=scaled(1.1, 1.2, 0.9),
    motor_constant=0.98 * WHEEL.motor_constant,
    table_inertia=1.03 * TABLE_INERTIA,
)
"""A corner of the dispersed runs: c 10 % and T_s 20 % too large, k_m too small."""
SHOWN = ("pid", "dmc_raw", "speed_mode", "compensator")
SPAN = (-15.0, 60.0)
"""s around the crossing."""


def _around(flown: TableRun, signal: Vector) -> tuple[Vector, Vector]:
    time = flown.time - flown.crossings()[0]
    near = (time >= SPAN[0]) & (time <= SPAN[1])
    return time[near], signal[0, near]


def crossing_figure() -> Figure:
    """Attitude error and commanded current around the crossing, for each controller."""
    contenders: list[Contender] = [c for key in SHOWN for c in CONTENDERS if c.key == key]
    flights = [
        fly(c.make(WRONG), DURATION, sensors=c.white, command_delay=1, seed=1) for c in contenders
    ]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.6), layout="constrained")
        whole, close, current = figure.subplots(3, 1, sharex=True, height_ratios=[1.3, 1.3, 1.0])
        for contender, flown in zip(contenders, flights, strict=True):
            time, attitude = _around(flown, np.degrees(flown.attitude))
            for axes in (whole, close):
                axes.plot(time, attitude, color=contender.colour, lw=1.3, label=contender.name)
            if contender.key in ("dmc_raw", "compensator"):
                current.plot(*_around(flown, 1e3 * flown.current), color=contender.colour, lw=0.9)
        for axes in (whole, close):
            axes.set_ylabel("attitude\nerror (deg)")
        close.set_ylim(-0.25, 0.25)
        whole.legend(loc="upper right")
        current.set_ylabel("current (mA)")
        current.set_xlabel("time from the crossing (s)")
    return figure


def side_by_side() -> Drawing:
    """The figure with its caption."""
    return Drawing(
        "Crossing zero, controllers side by side",
        crossing_figure(),
        "One run each: 5 rpm tachometer noise, gyro noise, one period of delay, c 10 % and T_s 20 "
        "% too large in the controller's model. Top, the whole error; middle, its small values; "
        "bottom, the current of the two compensators.",
    )
