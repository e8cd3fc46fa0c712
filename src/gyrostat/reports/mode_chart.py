"""Modes of the reference over the time of a run."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from gyrostat.core.text import plain
from gyrostat.core.types import Vector
from gyrostat.reports.axis import Axis
from gyrostat.reports.chart import COLOURS, Chart
from gyrostat.reports.chart_frame import BOTTOM, TOP
from gyrostat.telemetry.signals import runs

ROW = 29
"""Height of the row of a mode, in units of the chart."""


def mode_chart(names: Sequence[str], history: Mapping[Any, Any]) -> Chart | None:
    """Chart with a row for each mode, its stays and its time; None without two, or two samples.

    Args:
        names: Names of the modes.
        history: Histories of the run, with `mode`.
    """
    if len(names) < 2 or "mode" not in history or len(history["time"]) < 2:
        return None
    time, mode = (np.asarray(history[name], dtype=float) for name in ("time", "mode"))
    period = time[1] - time[0]
    last = len(names) - 1
    y = Axis(-0.5, last + 0.85, "")
    chart = Chart("mode", Axis(float(time[0]), float(time[-1]), "time (s)"), y)
    chart.height, chart.rows = TOP + BOTTOM + ROW * len(names), [*reversed(names)]
    changes = np.flatnonzero(np.diff(mode, prepend=np.nan))
    steps = np.repeat(np.r_[changes, len(mode) - 1], 2)[1:-1]
    chart.line(time[steps], last - np.repeat(mode[changes], 2), "", "s7")
    for number, name in enumerate(names):
        stays = [(time[a], min(time[b - 1] + period, time[-1])) for a, b in runs(mode == number)]
        length = sum(end - begin for begin, end in stays)
        text = f"{name}: {plain(length)} s" if stays else f"{name}: never"
        chart.stays(*_ends(stays), float(last - number), text, f"s{number % COLOURS}")
    return chart


def _ends(stays: Sequence[tuple[float, float]]) -> tuple[Vector, Vector]:
    begins, ends = np.array(stays, dtype=float).reshape(-1, 2).T
    return begins, ends
