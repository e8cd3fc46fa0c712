"""Figures like the paper's 1 to 6."""

from typing import TYPE_CHECKING

from matplotlib.axes import Axes

from gyrostat.papers.figures import INK, Drawing
from gyrostat.papers.moreira_lopes_kuga.setup import RADIUS, REFERENCE
from gyrostat.reports.colours import MARK, MEASURED, MODEL
from gyrostat.reports.drawing import panels

if TYPE_CHECKING:
    import xarray as xr


def figures(kalman: "xr.Dataset", plain: "xr.Dataset") -> tuple[Drawing, ...]:
    """Figures of one run with and one without the estimator."""
    return (
        momentum(kalman.isel(run=0)),
        friction(kalman.isel(run=0)),
        control(kalman.isel(run=0)),
        residual(kalman.isel(run=0)),
        comparison(kalman.isel(run=0), plain.isel(run=0)),
        control_without(plain.isel(run=0)),
    )


def momentum(one: "xr.Dataset") -> Drawing:
    """Fig. 1: momentum with its measurements and estimates."""
    with panels(height=3.0) as (figure, axes):
        axes.plot(one.time, one.measured_momentum, ".", ms=3, color=MEASURED, label="measured")
        axes.plot(one.time, one.estimated_momentum, "+", ms=4, color=MARK, label="estimated")
        axes.plot(one.time, one.momentum, color=MODEL, lw=1.2, label="wheel")
        axes.axhline(REFERENCE, color=INK, lw=0.7, ls="--")
        axes.set(xlabel="time (s)", ylabel="momentum (N·m·s)")
        axes.legend(loc="lower right")
    return Drawing("Momentum of the wheel (Fig. 1)", figure, "One run; dashed, the reference.")


def friction(one: "xr.Dataset") -> Drawing:
    """Fig. 2: friction torque, true and estimated."""
    with panels(height=3.0) as (figure, axes):
        axes.plot(one.time, 1e3 * one.estimated_friction, "+", ms=4, color=MARK, label="estimated")
        axes.plot(one.time, 1e3 * one.friction, color=MODEL, lw=1.4, label="bearing")
        axes.set(xlabel="time (s)", ylabel="friction torque (mN·m)")
        axes.legend(loc="lower right")
    caption = "The standard deviation of the estimates is as large as the torque."
    return Drawing("Friction torque (Fig. 2)", figure, caption)


def _torques(axes: Axes, run: "xr.Dataset") -> None:
    commanded = run.torque + run.fading_torque
    axes.step(run.time, 1e3 * commanded, where="post", color=MODEL, lw=0.9, label="commanded")
    axes.plot(run.time, 1e3 * (commanded - run.friction), ".", ms=3, color=MARK, label="effective")
    axes.set_ylabel("torque (mN·m)")
    axes.legend(loc="upper right")


def control(one: "xr.Dataset") -> Drawing:
    """Fig. 3: commanded and effective torque."""
    with panels(height=3.0) as (figure, axes):
        _torques(axes, one)
        axes.set_xlabel("time (s)")
    return Drawing("Control torque (Fig. 3)", figure, "Effective: commanded minus friction.")


def _deflection(axes: Axes, run: "xr.Dataset") -> None:
    axes.plot(run.time, 1e6 * RADIUS * run.bristle, color=MODEL, lw=1.2)
    axes.set_ylabel("deflection (µm)")


def residual(one: "xr.Dataset") -> Drawing:
    """Fig. 4: bristle deflection and residual."""
    with panels(2, height=4.2, sharex=True) as (figure, (top, bottom)):
        _deflection(top, one)
        bottom.plot(one.time, one.measured_momentum - one.estimated_momentum, ".", ms=3, color=MARK)
        bottom.set(xlabel="time (s)", ylabel="residual (N·m·s)")
    caption = "Measured minus estimated momentum."
    return Drawing("Bristle deflection and residual (Fig. 4)", figure, caption)


def comparison(kalman: "xr.Dataset", plain: "xr.Dataset") -> Drawing:
    """Fig. 5: momentum and friction torque with and without the estimator."""
    with panels(2, height=4.2, sharex=True) as (figure, (top, bottom)):
        for run, colour, name in ((kalman, MARK, "with"), (plain, MODEL, "without")):
            label = f"{name} estimator"
            top.plot(run.time, run.momentum, color=colour, lw=1.2, label=label)
            bottom.plot(run.time, 1e3 * run.friction, color=colour, lw=1.2, label=label)
        top.axhline(REFERENCE, color=INK, lw=0.7, ls="--")
        top.set_ylabel("momentum (N·m·s)")
        bottom.set(xlabel="time (s)", ylabel="friction (mN·m)")
        top.legend(loc="center right")
    return Drawing(
        "With and without estimator (Fig. 5)",
        figure,
        "Without the estimator (sign of (18) corrected), the momentum increases until the "
        "torque equals the friction.",
    )


def control_without(one: "xr.Dataset") -> Drawing:
    """Fig. 6: control torque and bristle deflection without the estimator."""
    with panels(2, height=4.2, sharex=True) as (figure, (top, bottom)):
        _torques(top, one)
        _deflection(bottom, one)
        bottom.set_xlabel("time (s)")
    return Drawing(
        "Control torque and bristle deflection without estimator (Fig. 6)",
        figure,
        "Effective: commanded minus friction.",
    )
