"""Figures corresponding to the paper's 5 to 10, and a figure of the dispersed cases."""

from collections.abc import Callable, Mapping

import numpy as np
from matplotlib.axes import Axes

from gyrostat.core.types import Vector
from gyrostat.papers.endo_sekiguchi_nonaka.controllers import OURS, SLOW, Outcome
from gyrostat.papers.endo_sekiguchi_nonaka.flights import Flight
from gyrostat.papers.endo_sekiguchi_nonaka.setup import DURATION, REQUIRED
from gyrostat.papers.figures import GREEN, INK, Drawing, label_edges
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels

Flights = Mapping[str, Flight]
EVERY = slice(None, None, 250)
"""Samples drawn, of the period 0.1 s."""


def _three(axes: Axes, flights: Flights, signal: Callable[[Flight], np.ndarray]) -> None:
    """Plot the paper's three runs: ideal, without MEC, proposed."""
    for flight, colour, style, label in (
        (flights["no_mec"], GREEN, "-", "without MEC"),
        (flights["mec_frit"], MARK, "-", "MEC with FRIT"),
        (flights["ideal"], MODEL, "--", "ideal"),
    ):
        line = {"color": colour, "lw": 1.2, "label": label}
        axes.plot(flight.time[EVERY], signal(flight)[EVERY], style, **line)
    axes.set_xlim(0.0, DURATION)


def figures(flights: Flights) -> tuple[Drawing, ...]:
    """Figures of the paper's own start."""
    return outputs(flights), pointing(flights), gains(flights), inputs(flights)


def outputs(flights: Flights) -> Drawing:
    """Figures 5 and 6: both outputs, and an enlarged view of their ends."""
    with panels(2, 2, height=4.6, sharex="col") as (figure, grid):
        for row in range(2):
            for column in range(2):
                axes = grid[row, column]
                _three(axes, flights, lambda flight, k=row: flight.output[:, k])
                axes.axhline(0.0, color=MEASURED, lw=0.6)
                if column == 1:
                    axes.set(xlim=(5000.0, DURATION), ylim=(-0.006, 0.006))
            grid[row, 0].set_ylabel(f"$h_{row + 1}$")
        label_edges(grid, "time (s)")
        grid[0, 0].legend(loc="upper right")
    return Drawing("Outputs (Figs. 5, 6)", figure, "Right, the second half magnified.")


def pointing(flights: Flights) -> Drawing:
    """Figure 7: pointing error of the paper's runs, and with fixed gains."""
    constant = [flight for name, flight in flights.items() if name.startswith("fixed_gain")]
    with panels(height=3.6) as (figure, axes):
        for flight in constant:
            axes.semilogy(flight.time[EVERY], flight.error[EVERY], color=MEASURED, lw=0.9)
        axes.plot([], [], color=MEASURED, lw=0.9, label="MEC with a fixed gain")
        _three(axes, flights, lambda flight: flight.error)
        axes.axhline(REQUIRED, color=INK, lw=0.8, ls=":")
        axes.set(xlabel="time (s)", ylabel="pointing error (deg)")
        axes.legend(loc="upper right")
    gains = ", ".join(f"{flight.gain[0, 0, 0]:g}" for flight in constant)
    caption = f"Dotted, the required accuracy. Grey, fixed gains K of {gains} 1/s."
    return Drawing("Pointing error (Fig. 7)", figure, caption)


def gains(flights: Flights) -> Drawing:
    """Figure 8: the four gains."""
    flight = flights["mec_frit"]
    with panels(height=3.4) as (figure, axes):
        for number, colour in enumerate((MODEL, GREEN, "#8a5fb0", MARK)):
            row, column = divmod(number, 2)
            line = {"color": colour, "lw": 1.2, "label": f"$K_{{{row + 1}{column + 1}}}$"}
            axes.plot(flight.time[EVERY], flight.gain[EVERY, row, column], **line)
        axes.set(xlim=(0.0, DURATION), xlabel="time (s)", ylabel="gain (1/s)")
        axes.legend(ncols=4)
    caption = "Constant while the dead zone suspends the update."
    return Drawing("Compensation gain (Fig. 8)", figure, caption)


def inputs(flights: Flights) -> Drawing:
    """Figures 9 and 10: wheel speeds."""
    with panels(2, height=4.2, sharex=True) as (figure, rows):
        for row, axes in enumerate(rows):
            _three(axes, flights, lambda flight, k=row: flight.speed[:, k])
            axes.set_ylabel(f"$u_{row + 1}$ (rad/s)")
        rows[1].set_xlabel("time (s)")
        rows[0].legend(loc="upper right")
    caption = "Each begins with a jump from rest that no motor could give."
    return Drawing("Wheel speeds (Figs. 9, 10)", figure, caption)


def dispersed_figure(quickest: Vector, found: Mapping[str, Outcome]) -> Drawing:
    """Plot settling times and final errors.

    Args:
        quickest: Shortest duration T of each case, s.
        found: Key of a candidate -> its runs.
    """
    with panels(1, 2, height=3.8) as (figure, (left, right)):
        left.plot(quickest, found[OURS.key].settled, ".", color=MODEL, ms=3.0)
        limit = np.array([0.0, np.max(quickest)])
        left.plot(limit, 1.1 * limit + 40.0, color=MARK, lw=0.9, label="1.10 T + 40 s")
        left.plot(limit, limit, color=MEASURED, lw=0.9, label="T")
        left.set(xlabel="shortest possible slew T (s)", ylabel="settling time (s)")
        left.legend()
        colours = (MODEL, MARK, GREEN, MEASURED)
        for candidate, colour in zip((OURS, *SLOW), colours, strict=True):
            error = np.sort(np.minimum(found[candidate.key].last, 180.0))
            share = (1.0 + np.arange(len(error))) / len(error)
            right.semilogx(error, share, color=colour, lw=1.2, label=candidate.name)
        right.axvline(REQUIRED, color=INK, lw=0.8, ls=":")
        right.set(xlabel="largest error in the final window (deg)", ylabel="share of cases")
        right.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)
    return Drawing(
        f"{len(quickest)} dispersed cases",
        figure,
        f"Left, {OURS.name}. Right, the share of cases that end below an error; dotted, the "
        "required accuracy.",
    )
