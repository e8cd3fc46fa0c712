"""How the recoveries go: the angle that is left, and what cannot be recovered."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from gyrostat.papers.carvalho_fenili.printed import CASES, LAWS, failure_of
from gyrostat.papers.carvalho_fenili.recoveries import DURATION, LOSSES, Recovered
from gyrostat.papers.reproduction import Drawing
from gyrostat.recovery import Recovery
from gyrostat.report.figures import MARK, MEASURED, MODEL, STYLE

COLOURS = dict(zip(LOSSES, (MODEL, MARK, "#4b8b3b"), strict=True))
STROKES = dict(zip(LAWS, ("-", "--"), strict=True))
LEAST = 1e-3
"""deg: nothing is drawn below."""
SETTLED = 0.05
"""deg."""


def recovery_drawing(runs: Mapping[str, Recovered]) -> Drawing:
    """The angle to the attitude aimed at, over time, of all recoveries; a line of text for each.

    Args:
        runs: of each law.
    """
    failing = [case for case in CASES if case != "none"]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.4), layout="constrained")
        grid = figure.subplots(2, 3, sharex=True, sharey=True)
        for axes, case in zip(grid.flat, failing, strict=True):
            axes.axhline(SETTLED, color=MEASURED, lw=0.8, ls=":")
            rows = [(law, kind) for law in runs for kind in LOSSES]
            for row, (law, kind) in enumerate(rows):
                recovery = runs[law].flown[case][kind]
                _history(axes, law, kind, recovery)
                _line_of_text(axes, row, law, kind, recovery)
            axes.set_yscale("log")
            # the upper half is for the texts
            axes.set_ylim(LEAST, 1e8)
            axes.set_yticks([1e-3, 1e-2, 1e-1, 1.0, 10.0, 100.0])
            axes.minorticks_off()
            axes.set_xlim(0.0, DURATION)
            axes.set_title(failure_of(case), fontsize=9, loc="left")
        for axes in grid[-1]:
            axes.set_xlabel("time from the failure (s)")
        for axes in grid[:, 0]:
            axes.set_ylabel("angle left (deg)")
        lines = [Line2D([], [], color="#22262b", lw=1.2, ls=style) for style in STROKES.values()]
        figure.legend(
            lines,
            [f"{name} before the failure" for name in LAWS.values()],
            loc="outside upper right",
            ncols=2,
            fontsize=8,
        )
    return Drawing(
        "The same failures, recovered",
        figure,
        "Angle to the nearest attitude that can be held, from the failure on; dotted, 0.05 deg. "
        "Texts: how the wheels failed, how far that attitude is from the target, and when the "
        "spacecraft has settled there for good.",
    )


def _history(axes: Axes, law: str, kind: str, recovery: Recovery) -> None:
    if recovery.flight is None:
        return
    left = np.degrees(recovery.flight.error.values)
    # the first fall to nothing is the end of the story
    end = int(np.argmax(left < LEAST)) + 1 if np.any(left < LEAST) else len(left)
    time = recovery.flight.time.values[:end]
    axes.plot(time, np.maximum(left[:end], LEAST), STROKES[law], color=COLOURS[kind], lw=1.1)


def _line_of_text(axes: Axes, row: int, law: str, kind: str, recovery: Recovery) -> None:
    answer = recovery.plan.answer
    if answer.angle is None:
        says = f"no rest, turns at {np.degrees(answer.for_ever.rate):.2g} deg/s or more"
    else:
        settle = recovery.settle
        missed = "no law gets there" if recovery.flight is None else "not settled"
        when = missed if settle is None else f"settled at {settle:.5g} s"
        says = f"{np.degrees(answer.angle):.3g} deg off, {when}"
    axes.text(
        0.03,
        0.965 - 0.068 * row,
        f"{LAWS[law]}, {kind}: {says}",
        transform=axes.transAxes,
        va="top",
        fontsize=6.5,
        color=COLOURS[kind],
    )
