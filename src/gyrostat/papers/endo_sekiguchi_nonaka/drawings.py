"""Figures like the paper's 5 to 10, and the other starts."""

from collections.abc import Callable, Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.papers.endo_sekiguchi_nonaka.flights import Flight
from gyrostat.papers.endo_sekiguchi_nonaka.fragility import CASES, LABELS, Outcome
from gyrostat.papers.endo_sekiguchi_nonaka.numbers import Flights
from gyrostat.papers.endo_sekiguchi_nonaka.printed import DURATION, REQUIRED
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import MARK, MEASURED, MODEL, STYLE

EVERY = 250
"""Samples of 0.1 s from one drawn point to the next."""
GREEN = "#4b8b3b"


def _three(
    axes: Axes, flights: Flights, signal: Callable[[Flight], np.ndarray], first: int = 0
) -> None:
    """The paper's three runs: ideal, without MEC, proposed."""
    for flight, colour, style, label in (
        (flights.no_mec, GREEN, "-", "without MEC"),
        (flights.mec_frit, MARK, "-", "MEC with FRIT"),
        (flights.ideal, MODEL, "--", "ideal"),
    ):
        axes.plot(
            flight.time[first::EVERY],
            signal(flight)[first::EVERY],
            style,
            color=colour,
            lw=1.2,
            label=label,
        )
    axes.set_xlim(0.0, DURATION)


def output_drawing(flights: Flights) -> Drawing:
    """Figures 5 and 6: both outputs, and a closer look at their ends."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.6), layout="constrained")
        grid = figure.subplots(2, 2, sharex="col")
        for row in range(2):
            for column in range(2):
                axes = grid[row, column]
                _three(axes, flights, lambda flight, k=row: flight.output[:, k])
                axes.axhline(0.0, color=MEASURED, lw=0.6)
                if column == 1:
                    axes.set_xlim(5000.0, DURATION)
                    axes.set_ylim(-0.006, 0.006)
            grid[row, 0].set_ylabel(f"$h_{row + 1}$")
        for axes in grid[1]:
            axes.set_xlabel("time (s)")
        grid[0, 0].legend(loc="upper right")
    return Drawing("Outputs (Figs. 5, 6)", figure, "Right, the second half magnified.")


def pointing_drawing(flights: Flights) -> Drawing:
    """Figure 7: pointing error, with the fixed gains beside the paper's runs."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        axes = figure.subplots()
        for flight in flights.fixed.values():
            axes.semilogy(flight.time[::EVERY], flight.error[::EVERY], color=MEASURED, lw=0.9)
        axes.plot([], [], color=MEASURED, lw=0.9, label="MEC with a fixed gain")
        _three(axes, flights, lambda flight: flight.error)
        axes.axhline(REQUIRED, color="#22262b", lw=0.8, ls=":")
        axes.set_ylabel("pointing error (deg)")
        axes.set_xlabel("time (s)")
        axes.legend(loc="upper right")
    gains = ", ".join(f"{flight.gain[0, 0, 0]:g}" for flight in flights.fixed.values())
    return Drawing(
        "Pointing error (Fig. 7)",
        figure,
        f"Dotted, the required accuracy. Grey, fixed gains K of {gains} 1/s.",
    )


def gain_drawing(flights: Flights) -> Drawing:
    """Figure 8: the four gains."""
    flight = flights.mec_frit
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.4), layout="constrained")
        axes = figure.subplots()
        for number, colour in enumerate((MODEL, GREEN, "#8a5fb0", MARK)):
            row, column = divmod(number, 2)
            axes.plot(
                flight.time[::EVERY],
                flight.gain[::EVERY, row, column],
                color=colour,
                lw=1.2,
                label=f"$K_{{{row + 1}{column + 1}}}$",
            )
        axes.set_xlim(0.0, DURATION)
        axes.set_ylabel("gain (1/s)")
        axes.set_xlabel("time (s)")
        axes.legend(ncols=4)
    return Drawing(
        "Compensation gain (Fig. 8)", figure, "Level where the dead zone holds the update."
    )


def input_drawing(flights: Flights) -> Drawing:
    """Figures 9 and 10: wheel speeds."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.2), layout="constrained")
        rows = figure.subplots(2, 1, sharex=True)
        for row, axes in enumerate(rows):
            _three(axes, flights, lambda flight, k=row: flight.speed[:, k])
            axes.set_ylabel(f"$u_{row + 1}$ (rad/s)")
        rows[1].set_xlabel("time (s)")
        rows[0].legend(loc="upper right")
    return Drawing(
        "Wheel speeds (Figs. 9, 10)",
        figure,
        "Each begins with a jump from rest that no motor could give.",
    )


def fragility_drawing(outcomes: Mapping[str, Sequence[Outcome]]) -> Drawing:
    """Pointing error of every other start, with tuning and with a fixed gain."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.0), layout="constrained")
        columns = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, (key, label) in zip(columns, LABELS.items(), strict=True):
            for one in outcomes[key]:
                colour = MODEL if one.holds else MARK
                axes.semilogy(one.time, one.error, color=colour, lw=0.9, alpha=0.8)
                if one.valid_until < DURATION:
                    axes.plot(one.valid_until, one.worst, "x", color=MARK)
            axes.axhline(REQUIRED, color="#22262b", lw=0.8, ls=":")
            axes.set_title(label, fontsize=9, loc="left")
            axes.set_xlim(0.0, DURATION)
            axes.set_xlabel("time (s)")
        columns[0].set_ylabel("pointing error (deg)")
    return Drawing(
        f"The same experiment from {len(CASES)} other starts",
        figure,
        "Red, runs that do not hold what is required; a cross where one diverges.",
    )
