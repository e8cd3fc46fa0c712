"""The figure of the dispersed cases."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gyrostat._types import Vector
from gyrostat.papers.endo_sekiguchi_nonaka.contenders import OURS, SLOW, Outcome
from gyrostat.papers.endo_sekiguchi_nonaka.printed import REQUIRED
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import MARK, MEASURED, MODEL, STYLE


def dispersed_drawing(quickest: Vector, ours: Outcome, others: Mapping[str, Outcome]) -> Drawing:
    """When runs settle, and the errors that they end with.

    Args:
        quickest: T of each case, s.
        ours: in each case.
        others: key of a contender -> its runs.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(quickest, ours.settled, ".", color=MODEL, ms=3.0)
        limit = np.array([0.0, np.max(quickest)])
        left.plot(limit, 1.1 * limit + 40.0, color=MARK, lw=0.9, label="1.10 T + 40 s")
        left.plot(limit, limit, color=MEASURED, lw=0.9, label="T")
        left.set_xlabel("quickest turn T (s)")
        left.set_ylabel("settled (s)")
        left.legend()
        lines = {OURS.name: (ours, MODEL)}
        for one, colour in zip(SLOW, (MARK, "#4b8b3b", MEASURED), strict=True):
            lines[one.name] = (others[one.key], colour)
        for name, (outcome, colour) in lines.items():
            error = np.sort(np.minimum(outcome.last, 180.0))
            share = (1.0 + np.arange(len(error))) / len(error)
            right.semilogx(error, share, color=colour, lw=1.2, label=name)
        right.axvline(REQUIRED, color="#22262b", lw=0.8, ls=":")
        right.set_xlabel("largest error in the judged window (deg)")
        right.set_ylabel("share of cases")
        right.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.18), ncols=2)
    return Drawing(
        f"{len(quickest)} dispersed cases",
        figure,
        f"Left, {OURS.name}. Right, the share of cases that end below an error; dotted, the "
        "required accuracy.",
    )
