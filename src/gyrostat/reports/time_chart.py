"""Charts of curves over time."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.reports.axis import Axis, axis_of
from gyrostat.reports.chart import COLOURS, Chart
from gyrostat.reports.thinned import thinned


def held(time: Vector, commands: Matrix) -> tuple[Vector, Matrix]:
    """Times and values of commands, (samples, curves), each of which is held until the next."""
    return np.repeat(time, 2)[1:], np.repeat(commands, 2, axis=0)[:-1]


def time_chart(
    time: Vector,
    values: Matrix,
    title: str,
    names: Sequence[str],
    most: int,
    *,
    is_log: bool = False,
) -> Chart:
    """Chart of some curves, (samples, curves), over time, s, with at most `most` points each."""
    x = Axis(float(time[0]), float(time[-1]), "time (s)")
    chart = Chart(title, x, axis_of(values.ravel(), "", is_log=is_log))
    for k, name in enumerate(names):
        chart.line(*thinned(time, values[:, k], most), name, f"s{k % COLOURS}")
    return chart
