"""Figures like the paper's 1 to 24, the frozen rates, and the same cases on wheels."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gyrostat.papers.carvalho_fenili.exchange import Exchange
from gyrostat.papers.carvalho_fenili.flights import Flight
from gyrostat.papers.carvalho_fenili.numbers import Flights
from gyrostat.papers.carvalho_fenili.printed import (
    AXES,
    CASES,
    DURATION,
    FAILURE,
    FIGURES,
    LAWS,
    failure_of,
)
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import MARK, MEASURED, MODEL, STYLE

COLOURS = (MODEL, MARK, "#4b8b3b")
LABELS = ("θ - π/2", "φ", "ψ")
GOAL = "#22262b"
EVERY = 20
"""Samples of 0.01 s from one drawn point to the next."""


def _time_marks(axes: Axes, until: float) -> None:
    axes.axhline(0.0, color=GOAL, lw=0.6)
    axes.axvline(FAILURE, color=GOAL, lw=0.8, ls=":")
    if until < DURATION - 0.5:
        axes.axvspan(until, DURATION, color="#eceef1", lw=0)
        axes.text(
            0.5 * (until + DURATION) if until < 170.0 else DURATION - 1.0,
            0.04,
            f"not valid\nfrom {until:.1f} s" if until < 170.0 else f"ends {until:.1f} s",
            transform=axes.get_xaxis_transform(),
            ha="center" if until < 170.0 else "right",
            va="bottom",
            color="#6b7077",
            fontsize=8,
        )
    axes.set_xlim(0.0, DURATION)


def _signed_log(axes: Axes, values: np.ndarray, threshold: float) -> None:
    """A scale that shows both what settles and what runs away."""
    if np.max(np.abs(values)) > 8.0 * threshold:
        axes.set_yscale("symlog", linthresh=threshold, linscale=1.0)
        axes.axhspan(-threshold, threshold, color="#f6f7f9", lw=0, zorder=0)


def _thin(count: int) -> np.ndarray:
    return np.unique(np.append(np.arange(0, count, EVERY), count - 1))


def case_drawing(case: str, flights: Flights, sampled: Flights) -> Drawing:
    """Angles and rates of one case by both laws, sampled-and-held runs dashed.

    Args:
        case: which torques fail.
        flights: with the law evaluated at every stage.
        sampled: with the law sampled and held.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.0), layout="constrained")
        grid = figure.subplots(2, 2, sharex=True)
        for column, law in enumerate(LAWS):
            flight, other = flights[law][case], sampled[law][case]
            _angle_axes(grid[0, column], flight, other)
            _rate_axes(grid[1, column], flight, other)
            grid[0, column].set_title(LAWS[law], fontsize=9, loc="left")
            grid[1, column].set_xlabel("time (s)")
        grid[0, 0].set_ylabel("angle (rad)")
        grid[1, 0].set_ylabel("rate of the angle (rad/s)")
        grid[0, 1].legend(*_key(), loc="lower left", bbox_to_anchor=(0.12, 1.0), ncols=4)
    if case not in FIGURES:
        return Drawing("No failure", figure, "Both laws reach the goal. " + _READ)
    first, second = FIGURES[case]
    title = failure_of(case).capitalize().replace(" m", " M")
    return Drawing(
        f"{title} at {FAILURE:g} s (Figs. {first}, {first + 1}, {second}, {second + 1})",
        figure,
        _READ,
    )


_READ = (
    "Dotted, the failure; dashed, the law sampled and held for 0.01 s; grey, beyond validity. "
    "Where values run away, the scale is linear inside the pale band and logarithmic outside."
)


def _key() -> tuple[list[Line2D], list[str]]:
    lines = [Line2D([], [], color=colour, lw=1.4) for colour in COLOURS]
    return [*lines, Line2D([], [], color=MEASURED, lw=1.0, ls="--")], [*LABELS, "held"]


def _angle_axes(axes: Axes, flight: Flight, sampled: Flight) -> None:
    _signed_log(axes, flight.angles, 1.0)
    for run, style in ((flight, "-"), (sampled, "--")):
        pick = _thin(len(run.time))
        for k, colour in enumerate(COLOURS):
            axes.plot(run.time[pick], run.angles[pick, k], style, color=colour, lw=1.2)
    _time_marks(axes, flight.valid_until)


def _rate_axes(axes: Axes, flight: Flight, sampled: Flight) -> None:
    _signed_log(axes, flight.rates, 0.1)
    for run, style in ((flight, "-"), (sampled, "--")):
        pick = _thin(len(run.time))
        for k, colour in enumerate(COLOURS):
            axes.plot(run.time[pick], run.rates[pick, k], style, color=colour, lw=1.2)
    _time_marks(axes, flight.valid_until)


def frozen_drawing(flights: Flights) -> Drawing:
    """Body rates of every failure: those about the failed axes are level from 15 s on."""
    failing = [case for case in CASES if case != "none"]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.6), layout="constrained")
        grid = figure.subplots(len(failing) // 2, 4, sharex=True, sharey=True)
        for number, case in enumerate(failing):
            for k, law in enumerate(LAWS):
                axes = grid[number // 2, 2 * (number % 2) + k]
                flight = flights[law][case]
                # what the steps do not resolve is no motion
                span = _thin(int(np.sum(flight.time <= flight.resolved_until + 1e-9)))
                for axis, colour in enumerate(COLOURS):
                    failed = axis in flight.failed
                    axes.plot(
                        flight.time[span],
                        flight.body_rate[span, axis],
                        color=colour,
                        lw=2.2 if failed else 0.9,
                        label=f"about {AXES[axis]}",
                    )
                _time_marks(axes, flight.resolved_until)
                axes.set_title(f"{case}, {LAWS[law]}", fontsize=8, loc="left")
                axes.set_ylim(-0.11, 0.11)
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        for axes in grid[:, 0]:
            axes.set_ylabel("body rate (rad/s)")
        grid[0, 0].legend(loc="upper right", fontsize=7)
    return Drawing(
        "Why no law can help: the rate about a failed axis is frozen",
        figure,
        "Thick, the failed axes: I dw/dt = M = 0 keeps their rates level from the dotted line on, "
        "with any law. Thin, the axes that are still driven; what leaves the frame spins up.",
    )


def exchange_drawing(flights: Flights, exchanged: Mapping[str, Mapping[str, Exchange]]) -> Drawing:
    """Length of the body rate of every failure, in the paper's plant and on wheels."""
    failing = [case for case in CASES if case != "none"]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 5.0), layout="constrained")
        grid = figure.subplots(2, 3, sharex=True, sharey=True)
        for axes, case in zip(grid.flat, failing, strict=True):
            for law, colour in zip(LAWS, (MODEL, MARK), strict=True):
                flight, wheels = flights[law][case], exchanged[law][case]
                span = _thin(int(np.sum(flight.time <= flight.resolved_until + 1e-9)))
                rate = np.linalg.norm(flight.body_rate[span], axis=1)
                axes.semilogy(
                    flight.time[span],
                    rate,
                    "--",
                    color=colour,
                    lw=1.0,
                    label=f"{LAWS[law]}, body torques",
                )
                axes.semilogy(
                    wheels.time,
                    np.linalg.norm(wheels.body_rate, axis=1),
                    color=colour,
                    lw=1.3,
                    label=f"{LAWS[law]}, wheels",
                )
            axes.axvline(FAILURE, color=GOAL, lw=0.8, ls=":")
            axes.set_xlim(0.0, DURATION)
            axes.set_ylim(5e-5, 20.0)
            axes.set_title(failure_of(case), fontsize=9, loc="left")
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        for axes in grid[:, 0]:
            axes.set_ylabel("body rate (rad/s)")
        grid[0, 0].legend(loc="upper right", fontsize=7)
    return Drawing(
        "The same failures on wheels",
        figure,
        "Dashed, the paper's plant, where the frozen rate is the least that is possible; solid, "
        "three wheels, where the failed one keeps its momentum instead. A line that stops has "
        "spun up or come to the singularity of the angles. Neither law knows of the failure.",
    )
