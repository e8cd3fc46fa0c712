"""Figures like the paper's 1 to 6."""

from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.papers.moreira_lopes_kuga.printed import RADIUS, REFERENCE
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import BAND, MARK, MEASURED, MODEL, STYLE

if TYPE_CHECKING:
    import xarray as xr


def _figure(rows: int, height: float) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(9.0, height), layout="constrained")
    axes = np.atleast_1d(figure.subplots(rows, 1, sharex=True))
    axes[-1].set_xlabel("time (s)")
    return figure, list(axes)


def _commanded_and_effective(axes: Axes, one: "xr.Dataset") -> None:
    commanded = one.torque + one.fading_torque
    axes.step(one.time, 1e3 * commanded, where="post", color=MODEL, lw=0.9, label="commanded")
    axes.plot(one.time, 1e3 * (commanded - one.friction), ".", ms=3, color=MARK, label="effective")
    axes.set_ylabel("torque (mN·m)")
    axes.legend(loc="upper right")


def momentum_drawing(flown: "xr.Dataset") -> Drawing:
    """Fig. 1: momentum of one run with its measurements and estimates."""
    one = flown.isel(run=0)
    with mpl.rc_context(STYLE):
        figure, (axes,) = _figure(1, 3.0)
        axes.plot(one.time, one.measured_momentum, ".", ms=3, color=MEASURED, label="measured")
        axes.plot(one.time, one.estimated_momentum, "+", ms=4, color=MARK, label="estimated")
        axes.plot(one.time, one.momentum, color=MODEL, lw=1.2, label="wheel")
        axes.axhline(REFERENCE, color="#22262b", lw=0.7, ls="--")
        axes.set_ylabel("momentum (N·m·s)")
        axes.legend(loc="lower right")
    return Drawing("Momentum of the wheel (Fig. 1)", figure, "One run; dashed, the reference.")


def torque_drawing(flown: "xr.Dataset") -> Drawing:
    """Fig. 2: friction torque of one run, true and estimated."""
    one = flown.isel(run=0)
    with mpl.rc_context(STYLE):
        figure, (axes,) = _figure(1, 3.0)
        axes.plot(one.time, 1e3 * one.estimated_friction, "+", ms=4, color=MARK, label="estimated")
        axes.plot(one.time, 1e3 * one.friction, color=MODEL, lw=1.4, label="bearing")
        axes.set_ylabel("friction torque (mN·m)")
        axes.legend(loc="lower right")
    return Drawing(
        "Friction torque (Fig. 2)", figure, "The estimates scatter as much as the torque is large."
    )


def control_drawing(flown: "xr.Dataset") -> Drawing:
    """Fig. 3: commanded and effective torque of one run."""
    with mpl.rc_context(STYLE):
        figure, (axes,) = _figure(1, 3.0)
        _commanded_and_effective(axes, flown.isel(run=0))
    return Drawing("Control torque (Fig. 3)", figure, "Effective: commanded minus friction.")


def residual_drawing(flown: "xr.Dataset") -> Drawing:
    """Fig. 4: bristle deflection and residual of one run."""
    one = flown.isel(run=0)
    with mpl.rc_context(STYLE):
        figure, (top, bottom) = _figure(2, 4.2)
        top.plot(one.time, 1e6 * RADIUS * one.bristle, color=MODEL, lw=1.2)
        top.set_ylabel("deflection (µm)")
        bottom.plot(one.time, one.measured_momentum - one.estimated_momentum, ".", ms=3, color=MARK)
        bottom.set_ylabel("residual (N·m·s)")
    return Drawing(
        "Bristle deflection and residual (Fig. 4)", figure, "Measured minus estimated momentum."
    )


def without_drawing(kalman: "xr.Dataset", plain: "xr.Dataset") -> Drawing:
    """Fig. 5: momentum and friction torque of one run with and without the estimator."""
    with mpl.rc_context(STYLE):
        figure, (momentum, torque) = _figure(2, 4.2)
        for flown, colour, name in ((kalman, MARK, "with"), (plain, MODEL, "without")):
            one = flown.isel(run=0)
            label = f"{name} estimator"
            momentum.plot(one.time, one.momentum, color=colour, lw=1.2, label=label)
            torque.plot(one.time, 1e3 * one.friction, color=colour, lw=1.2, label=label)
        momentum.axhline(REFERENCE, color="#22262b", lw=0.7, ls="--")
        momentum.set_ylabel("momentum (N·m·s)")
        torque.set_ylabel("friction (mN·m)")
        momentum.legend(loc="center right")
    return Drawing(
        "With and without estimator (Fig. 5)",
        figure,
        "Without the estimator, sign of (18) corrected, the momentum stops growing where the "
        "torque equals the friction.",
    )


def without_control_drawing(plain: "xr.Dataset") -> Drawing:
    """Fig. 6: control torque and bristle deflection of one run without the estimator."""
    one = plain.isel(run=0)
    with mpl.rc_context(STYLE):
        figure, (torque, deflection) = _figure(2, 4.2)
        _commanded_and_effective(torque, one)
        deflection.plot(one.time, 1e6 * RADIUS * one.bristle, color=MODEL, lw=1.2)
        deflection.set_ylabel("deflection (µm)")
    return Drawing(
        "Control torque and bristle deflection without estimator (Fig. 6)",
        figure,
        "Effective: commanded minus friction.",
    )


def together_drawing(
    paper: "xr.Dataset", ours: "xr.Dataset", stepped: "xr.Dataset", when: float, level: float
) -> Drawing:
    """What a friction model brings: momentum and friction torque of both filters.

    Args:
        paper: runs with the paper's filter.
        ours: runs with the filter that carries a model.
        stepped: the same while the friction steps.
        when: time of the step, s.
        level: friction at the reference after it, N·m.
    """
    with mpl.rc_context(STYLE):
        figure, (momentum, torque, step) = _figure(3, 6.6)
        for flown, colour, name in ((paper, MARK, "paper"), (ours, MODEL, "with a wrong model")):
            one = flown.isel(run=0)
            momentum.plot(one.time, one.momentum, color=colour, lw=1.3, label=name)
            torque.plot(one.time, 1e3 * one.estimated_friction, "+", ms=4, color=colour, label=name)
        torque.plot(ours.time, 1e3 * ours.friction.isel(run=0), color="#22262b", lw=0.9)
        torque.set_ylim(-40.0, 80.0)
        estimates = 1e3 * stepped.estimated_friction
        low, high = (estimates.quantile(q, "run") for q in (0.025, 0.975))
        step.fill_between(stepped.time, low, high, color=BAND, lw=0, label="95 % of the runs")
        step.plot(stepped.time, estimates.mean("run"), color=MODEL, lw=1.2, label="mean")
        step.axhline(1e3 * level, color="#22262b", lw=0.8, ls="--", label="level after the step")
        step.axvline(when, color=MARK, lw=0.8)
        step.set_ylim(0.0, 40.0)
        momentum.set_ylabel("momentum (N·m·s)")
        torque.set_ylabel("friction (mN·m)")
        step.set_ylabel("friction (mN·m)")
        for axes in (momentum, torque, step):
            axes.legend(loc="lower right", ncols=3)
    return Drawing(
        "Both filters on the same measurements",
        figure,
        "Top and middle, one run: the paper's filter and controller, and the filter that carries a "
        "friction model wrong by 10 %; black, the true friction. Bottom, that filter while the "
        "friction grows by half.",
    )
