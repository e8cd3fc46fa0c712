"""Figures 2 to 6 of the paper, from virtual records."""

import numpy as np
from matplotlib.axes import Axes

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.papers.carrara_kuga.bench import Prediction, Trial
from gyrostat.papers.carrara_kuga.setup import DETERMINISTIC, STATISTICAL
from gyrostat.papers.figures import GREY, Drawing
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels

COLUMNS = "profile 1, sines", "profile 2, steps"
NEAR_ZERO = 16.0 * RPM
"""Speed range of the enlarged view, rad/s: four Stribeck speeds."""


def friction() -> Drawing:
    """Fig. 2: the friction curve of both columns of Table 1, whole and near zero speed."""
    columns = ((STATISTICAL, MODEL, "statistical"), (DETERMINISTIC, MARK, "deterministic"))
    with panels(1, 2, height=3.4) as (figure, (wide, near)):
        for axes, limit in ((wide, 200.0 * RPM), (near, NEAR_ZERO)):
            half = jnp.linspace(0.0, limit, 400)
            for column, colour, label in columns:
                for sense, name in ((-1.0, None), (1.0, label)):
                    torque = jax.vmap(column.friction().torque, (0, None))(sense * half, sense)
                    speed = sense * np.asarray(half) / RPM
                    axes.plot(speed, 1e3 * np.asarray(torque), color=colour, lw=1.3, label=name)
            axes.axhline(0.0, lw=0.6, color=GREY)
            axes.set(xlabel="speed (rpm)", ylabel="friction torque (mN·m)")
        wide.legend(loc="upper left")
        near.set(xlim=(0.0, NEAR_ZERO / RPM), ylim=(0.87, 0.91))
    return Drawing(
        "Friction torque (Fig. 2)",
        figure,
        "Both columns of Table 1; right, the Stribeck term near zero speed, 3 % of the Coulomb "
        "torque. The curve jumps by twice the static torque where the rotation reverses.",
    )


def profiles(trial: Trial) -> Drawing:
    """Fig. 3: commanded current and measured speed."""
    with panels(2, 2, height=4.2, sharex=True, height_ratios=[1.0, 1.6]) as (figure, grid):
        for column, prediction in enumerate((trial.profile1, trial.profile2)):
            record = prediction.record
            top, bottom = grid[0, column], grid[1, column]
            top.step(record.time, 1e3 * record.current, where="post", lw=0.9, color="#444a52")
            top.set_title(COLUMNS[column], fontsize=9)
            _points(bottom, record.time, record.speed, "measured")
            bottom.axhline(0.0, lw=0.6, color=GREY)
            bottom.set_xlabel("time (s)")
        grid[0, 0].set_ylabel("current (mA)")
        grid[1, 0].set_ylabel("speed (rpm)")
        figure.align_ylabels(grid[:, 0])
    caption = "One virtual record of each. The slope changes at zero speed by the Coulomb torque."
    return Drawing("The two profiles (Fig. 3)", figure, caption)


def speeds(trial: Trial) -> Drawing:
    """Figs. 4 and 5: measured speed and both models."""
    with panels(2, height=6.4) as (figure, rows):
        pairs = zip(rows, (trial.profile1, trial.profile2), COLUMNS, strict=True)
        for axes, prediction, title in pairs:
            record = prediction.record
            _points(axes, record.time, record.speed, "measured")
            for speed, colour, label in (
                (prediction.deterministic, MARK, "deterministic"),
                (prediction.statistical, MODEL, "statistical (estimated)"),
            ):
                axes.plot(record.time, speed / RPM, lw=1.2, color=colour, label=label)
            axes.set_title(title, fontsize=9)
            axes.set(xlabel="time (s)", ylabel="speed (rpm)")
            axes.legend(loc="upper right", ncols=3)
            axes.margins(y=0.18)
    return Drawing(
        "Deterministic and statistical model (Figs. 4 and 5)",
        figure,
        "The estimate from profile 2, and the deterministic column with T_s = c.",
    )


def residuals(trial: Trial) -> Drawing:
    """Fig. 6: measured speed above, residuals of both models below."""
    options = {"sharex": True, "sharey": "row", "height_ratios": [1.0, 1.4]}
    with panels(2, 2, height=4.6, **options) as (figure, grid):
        for column, prediction in enumerate((trial.profile1, trial.profile2)):
            _residual_axes(grid[0, column], grid[1, column], prediction)
            grid[0, column].set_title(COLUMNS[column], fontsize=9)
        grid[0, 0].set_ylabel("measured (rpm)")
        grid[1, 0].set_ylabel("residual (rpm)")
        grid[1, 0].legend(loc="upper left", markerscale=4.0)
        figure.align_ylabels(grid[:, 0])
    return Drawing(
        "Residuals (Fig. 6)",
        figure,
        "Measured minus modelled. Those of the estimate are the tachometer noise alone: the "
        "friction of the virtual wheel is exactly that of eq. (1).",
    )


def _residual_axes(top: Axes, bottom: Axes, prediction: Prediction) -> None:
    time = prediction.record.time
    _points(top, time, prediction.record.speed, None)
    for residual, colour, label in (
        (prediction.deterministic_residual, MARK, "deterministic"),
        (prediction.residual, MODEL, "statistical (estimated)"),
    ):
        bottom.plot(time, residual / RPM, ".", ms=1.6, color=colour, label=label, rasterized=True)
    bottom.set_xlabel("time (s)")


def _points(axes: Axes, time: Vector, speed: Vector, label: str | None) -> None:
    axes.plot(time, speed / RPM, ".", ms=2, color=MEASURED, label=label, rasterized=True)
