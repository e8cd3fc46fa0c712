"""Page of a designed bench record."""

import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.units import RPM, si_unit
from gyrostat.identification.bench_tests.design_rehearsal import HEADER as CHECK_HEADER
from gyrostat.identification.bench_tests.design_rehearsal import DesignCheck
from gyrostat.identification.experiment.design import Design
from gyrostat.identification.experiment.design_text import HEADER, rows, summary
from gyrostat.reports.colours import MARK, MODEL
from gyrostat.reports.drawing import panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.template import render


def design_figure(design: Design) -> Figure:
    """Plot current, predicted speed and predicted standard deviation over time."""
    first = design.wanted[0]
    with panels(3, height=6.4, layout=None, sharex=True) as (figure, axes):
        figure.subplots_adjust(left=0.09, right=0.99, bottom=0.075, top=0.985, hspace=0.1)
        axes[0].step(design.time, design.current, where="post", lw=1.0, color="#444a52")
        axes[0].set_ylabel("current (A)")
        axes[1].plot(design.time, design.speed / RPM, lw=1.2, color=MODEL)
        axes[1].set_ylabel("speed of the estimate (rpm)")
        when, sigma = design.history
        axes[2].semilogy(
            np.append(0.0, when), np.append(first.before, sigma), lw=1.2, color=MODEL, marker="."
        )
        if first.target is not None:
            axes[2].axhline(first.target, lw=0.9, ls="--", color=MARK, label="wanted")
            axes[2].legend(loc="upper right")
        axes[2].set_ylabel(f"sigma of {first.name} ({si_unit(first.dimension)})")
        axes[2].set_xlabel("time (s)")
        figure.align_ylabels(axes)
    return figure


def design_page(design: Design, *, command: str, check: DesignCheck | None = None) -> str:
    """HTML page of a designed record.

    Args:
        design: The design.
        command: Command line that produced it.
        check: Simulated records of the design; None without them.
    """
    return render(
        "design.html",
        design=design,
        command=command,
        summary=summary(design),
        header=HEADER,
        rows=rows(design),
        figure=figure_charts(design_figure(design)),
        check=check,
        check_header=CHECK_HEADER,
    )
