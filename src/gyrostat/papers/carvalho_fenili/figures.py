"""Figures corresponding to the paper's 1 to 24, of the constant rates and of the recoveries."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from gyrostat.failures import Recovery
from gyrostat.papers.carvalho_fenili import setup
from gyrostat.papers.carvalho_fenili.flights import Flight, Flights
from gyrostat.papers.figures import GREEN, GREY, INK, Drawing, label_edges
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels

COLOURS = (MODEL, MARK, GREEN)
LABELS = ("θ - π/2", "φ", "ψ")
EVERY = 20
"""Number of samples of 0.01 s between drawn points."""
READING = (
    "Dotted: the failure. Grey: beyond validity. For diverging values, the scale is linear inside "
    "the pale band and logarithmic outside."
)
KINDS = {"frozen": MODEL, "seized": MARK, "rundown": GREEN}
STROKES = dict(zip(setup.LAWS, ("-", "--"), strict=True))
LEAST, SETTLED = 1e-3, 0.05
"""Smallest angle drawn, and angle at which a recovery has settled, deg."""


def _time_marks(axes: Axes, until: float) -> None:
    axes.axhline(0.0, color=INK, lw=0.6)
    axes.axvline(setup.FAILURE, color=INK, lw=0.8, ls=":")
    if until < setup.DURATION - 0.5:
        axes.axvspan(until, setup.DURATION, color="#eceef1", lw=0)
        wide = until < 170.0
        axes.text(
            0.5 * (until + setup.DURATION) if wide else setup.DURATION - 1.0,
            0.04,
            f"not valid\nfrom {until:.1f} s" if wide else f"ends {until:.1f} s",
            transform=axes.get_xaxis_transform(),
            ha="center" if wide else "right",
            va="bottom",
            color=GREY,
            fontsize=8,
        )
    axes.set_xlim(0.0, setup.DURATION)


def _thin(count: int) -> np.ndarray:
    return np.unique(np.append(np.arange(0, count, EVERY), count - 1))


def _histories(axes: Axes, flight: Flight, values: np.ndarray, threshold: float) -> None:
    """Plot three signals on a scale that shows both settling and diverging ones."""
    if np.max(np.abs(values)) > 8.0 * threshold:
        axes.set_yscale("symlog", linthresh=threshold, linscale=1.0)
        axes.axhspan(-threshold, threshold, color="#f6f7f9", lw=0, zorder=0)
    pick = _thin(len(flight.time))
    for k, colour in enumerate(COLOURS):
        axes.plot(flight.time[pick], values[pick, k], color=colour, lw=1.2)
    _time_marks(axes, flight.valid_until)


def case(case: str, flights: Flights) -> Drawing:
    """Plot angles and rates of one case with both laws.

    Args:
        case: Key of the case: which torques fail.
        flights: Runs by law and case.
    """
    with panels(2, 2, height=5.0, sharex=True) as (figure, grid):
        for column, law in enumerate(setup.LAWS):
            flight = flights[law][case]
            _histories(grid[0, column], flight, flight.angles, 1.0)
            _histories(grid[1, column], flight, flight.rates, 0.1)
            grid[0, column].set_title(setup.LAWS[law], fontsize=9, loc="left")
        label_edges(grid, "time (s)")
        grid[0, 0].set_ylabel("angle (rad)")
        grid[1, 0].set_ylabel("rate of the angle (rad/s)")
        lines = [Line2D([], [], color=colour, lw=1.4) for colour in COLOURS]
        grid[0, 1].legend(lines, LABELS, loc="lower left", bbox_to_anchor=(0.3, 1.0), ncols=3)
    if case not in setup.FIGURES:
        return Drawing("No failure", figure, "Both laws reach the goal. " + READING)
    first, second = setup.FIGURES[case]
    title = setup.failure_of(case).capitalize().replace(" m", " M")
    numbers = f"Figs. {first}, {first + 1}, {second}, {second + 1}"
    return Drawing(f"{title} at {setup.FAILURE:g} s ({numbers})", figure, READING)


def frozen_rates(flights: Flights) -> Drawing:
    """Plot the body rates of every failure; those about failed axes are constant from 15 s on."""
    with panels(len(setup.FAILING) // 2, 4, height=5.6, sharex=True, sharey=True) as (figure, grid):
        for number, case in enumerate(setup.FAILING):
            for k, law in enumerate(setup.LAWS):
                axes = grid[number // 2, 2 * (number % 2) + k]
                flight = flights[law][case]
                span = _thin(int(np.sum(flight.time <= flight.resolved_until + 1e-9)))
                for axis, colour in enumerate(COLOURS):
                    width = 2.2 if axis in flight.failed else 0.9
                    line = {"color": colour, "lw": width, "label": f"about {setup.AXES[axis]}"}
                    axes.plot(flight.time[span], flight.body_rate[span, axis], **line)
                _time_marks(axes, flight.resolved_until)
                axes.set_title(f"{case}, {setup.LAWS[law]}", fontsize=8, loc="left")
                axes.set_ylim(-0.11, 0.11)
        label_edges(grid, "time (s)", "body rate (rad/s)")
        grid[0, 0].legend(loc="upper right", fontsize=7)
    return Drawing(
        "The rate about a failed axis is constant under every law",
        figure,
        "Thick: failed axes. I dw/dt = M = 0 keeps their rates constant from the failure (dotted) "
        "on, under every law. Thin: driven axes; rates that leave the frame diverge.",
    )


def recovery_figure(runs: Mapping[str, Mapping[str, Mapping[str, Recovery]]]) -> Drawing:
    """Plot the angle to the target attitude of all recoveries over time, with a line of text each.

    Args:
        runs: Recoveries by law, case and kind of loss.
    """
    with panels(2, 3, height=6.4, sharex=True, sharey=True) as (figure, grid):
        for axes, case in zip(grid.flat, setup.FAILING, strict=True):
            axes.axhline(SETTLED, color=MEASURED, lw=0.8, ls=":")
            for row, (law, kind) in enumerate((law, kind) for law in runs for kind in KINDS):
                _history(axes, law, kind, runs[law][case][kind])
                _line_of_text(axes, row, law, kind, runs[law][case][kind])
            # the upper half is reserved for the texts
            axes.set(yscale="log", xlim=(0.0, 600.0), ylim=(LEAST, 1e8))
            axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0])
            axes.minorticks_off()
            axes.set_title(setup.failure_of(case), fontsize=9, loc="left")
        label_edges(grid, "time from the failure (s)", "remaining angle (deg)")
        lines = [Line2D([], [], color=INK, lw=1.2, ls=style) for style in STROKES.values()]
        names = [f"{name} before the failure" for name in setup.LAWS.values()]
        figure.legend(lines, names, loc="outside upper right", ncols=2, fontsize=8)
    return Drawing(
        "The same failures, recovered",
        figure,
        "Angle to the nearest attitude that can be held, from the failure on; dotted, 0.05 deg. "
        "Texts: how the wheels failed, how far that attitude is from the target, and when the "
        "spacecraft settles there.",
    )


def _history(axes: Axes, law: str, kind: str, recovery: Recovery) -> None:
    if recovery.flight is None:
        return
    remaining = np.degrees(recovery.flight.error.values)
    # up to the first sample below the smallest angle drawn
    end = int(np.argmax(remaining < LEAST)) + 1 if np.any(remaining < LEAST) else len(remaining)
    time = recovery.flight.time.values[:end]
    axes.plot(time, np.maximum(remaining[:end], LEAST), STROKES[law], color=KINDS[kind], lw=1.1)


def _line_of_text(axes: Axes, row: int, law: str, kind: str, recovery: Recovery) -> None:
    answer = recovery.plan.answer
    if answer.angle is None:
        text = f"no rest, turns at {np.degrees(answer.for_ever.rate):.2g} deg/s or more"
    else:
        missed = "no controller" if recovery.flight is None else "not settled"
        settle = recovery.settle
        when = missed if settle is None else f"settled at {settle:.5g} s"
        text = f"{np.degrees(answer.angle):.3g} deg off, {when}"
    axes.text(
        0.03,
        0.965 - 0.068 * row,
        f"{setup.LAWS[law]}, {kind}: {text}",
        transform=axes.transAxes,
        va="top",
        fontsize=6.5,
        color=KINDS[kind],
    )
