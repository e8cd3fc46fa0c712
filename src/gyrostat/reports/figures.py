"""Figures of records, fits and friction curves."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification import Fit
from gyrostat.identification.statistics import autocorrelation, crossing_times
from gyrostat.identification.torque_points import torque_points
from gyrostat.reports.drawing import BAND, MARK, MEASURED, MODEL, STYLE
from gyrostat.telemetry import Record

LARGEST_PLOT = 6000
"""Number of points above which a series is thinned for drawing."""


def _thin(count: int) -> slice:
    return slice(None, None, max(1, count // LARGEST_PLOT))


def _speed_axes(axes: Axes, record: Record, predicted: Vector) -> None:
    pick = _thin(len(record.time))
    time = record.time[pick]
    axes.plot(
        time, record.speed[pick] / RPM, ".", ms=2, color=MEASURED, label="measured", rasterized=True
    )
    axes.plot(time, predicted[pick] / RPM, "-", lw=1.2, color=MODEL, label="model")
    axes.set_ylabel("speed (rpm)")


def record_figure(
    record: Record, predicted: Vector, predicted_sigma: Vector | None, noise: float
) -> Figure:
    """Plot current, speed and residuals of a record over time, with zero crossings marked.

    Args:
        record: The measured record.
        predicted: Modelled speed, (N,), rad/s.
        predicted_sigma: Standard deviation of the modelled speed, (N,), rad/s, or None.
        noise: Standard deviation of the measured speed, rad/s.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.4))
        figure.subplots_adjust(left=0.08, right=0.99, bottom=0.075, top=0.985, hspace=0.1)
        rows = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 2.2, 1.4])
        pick = _thin(len(record.time))
        time = record.time[pick]
        rows[0].step(time, record.current[pick], where="post", lw=0.9, color="#444a52")
        rows[0].set_ylabel("current (A)")
        _speed_axes(rows[1], record, predicted)
        residual = (record.speed - predicted) / RPM
        rows[2].plot(time, residual[pick], ".", ms=2, color=MEASURED, rasterized=True)
        spread = np.zeros_like(predicted) if predicted_sigma is None else predicted_sigma
        band = 2.0 * np.sqrt(spread**2 + noise**2) / RPM
        rows[2].plot(time, band[pick], lw=0.9, color=MODEL, label="95 % prediction interval")
        rows[2].plot(time, -band[pick], lw=0.9, color=MODEL)
        rows[2].set_ylabel("residual (rpm)")
        rows[2].set_xlabel("time (s)")
        crossings = crossing_times(record.time, predicted, noise)
        for axes in rows[1:]:
            label = f"zero crossings ({len(crossings)})" if axes is rows[1] else None
            for k, when in enumerate(crossings[:200]):
                axes.axvline(when, lw=0.7, color=MARK, alpha=0.6, label=None if k else label)
            if axes is rows[1]:
                axes.axhline(0.0, lw=0.6, color="#6b7077")
        rows[1].legend(loc="upper right", ncols=3)
        rows[2].legend(loc="upper right")
        figure.align_ylabels(rows)
    return figure


def friction_figure(fit: Fit) -> Figure:
    """Plot the friction curve with its 95 % band and a histogram of the data over speed."""
    speeds = np.concatenate([r.speed[r.valid] for r in fit.records])
    reach = float(np.max(np.abs(speeds))) or 1.0
    scale = fit.parameters.get("stribeck_speed", 0.02 * reach)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.2))
        figure.subplots_adjust(left=0.08, right=0.99, bottom=0.11, top=0.94, wspace=0.14)
        grid = figure.subplots(2, 2, height_ratios=[4.0, 1.0], sharex="col")
        limits = (reach, min(8.0 * scale, reach))
        curves = _friction_curves(fit, limits)
        for column, limit in enumerate(limits):
            _friction_axes(grid[0, column], fit, limit, curves[column])
            inside = speeds[np.abs(speeds) <= limit] / RPM
            # one outline: sixty separate bars would take longer than the rest of the figure
            grid[1, column].stairs(
                *np.histogram(inside, bins=60, range=(-limit / RPM, limit / RPM)),
                fill=True,
                color=MEASURED,
            )
            grid[1, column].set_xlabel("speed (rpm)")
            grid[1, column].set_xlim(-1.03 * limit / RPM, 1.03 * limit / RPM)
        grid[0, 0].set_title("whole range", fontsize=9)
        grid[0, 1].set_title("near zero speed", fontsize=9)
        grid[0, 0].set_ylabel("friction torque (mN·m)")
        grid[1, 0].set_ylabel("samples")
        grid[0, 0].legend(loc="upper left")
    return figure


def _friction_curves(fit: Fit, limits: Sequence[float]) -> list[list[tuple[Vector, ...]]]:
    """Speed, torque and sigma on both sides of zero for each limit, evaluated in one call."""
    half = np.linspace(1e-6, 1.0, 200)
    speeds = [np.sort(sense * half * limit) for limit in limits for sense in (-1.0, 1.0)]
    torque, sigma = (np.split(v, len(speeds)) for v in fit.friction_curve(np.concatenate(speeds)))
    sides = list(zip(speeds, torque, sigma, strict=True))
    return [sides[2 * k : 2 * k + 2] for k in range(len(limits))]


def _friction_axes(axes: Axes, fit: Fit, limit: float, sides: Sequence[tuple[Vector, ...]]) -> None:
    for speed, torque, sigma in sides:
        first = speed[0] < 0.0
        axes.fill_between(
            speed / RPM,
            (torque - 2.0 * sigma) * 1e3,
            (torque + 2.0 * sigma) * 1e3,
            color=BAND,
            alpha=0.7,
            lw=0,
            label="95 % band" if first else None,
        )
        axes.plot(speed / RPM, torque * 1e3, color=MODEL, lw=1.4, label="model" if first else None)
    points = fit.friction_points or torque_points(fit)
    if points is not None:
        near = np.abs(points.speed) <= limit
        axes.errorbar(
            points.speed[near] / RPM,
            points.torque[near] * 1e3,
            2.0 * points.sigma[near] * 1e3,
            fmt="none" if points.when is not None else "o",
            ms=3,
            color=MARK,
            lw=0.8,
            label="steady speeds" if points.when is None else None,
        )
        if points.when is not None:
            axes.scatter(
                points.speed[near] / RPM,
                points.torque[near] * 1e3,
                14,
                points.when[near],
                cmap="copper",
                vmin=0.0,
                vmax=1.0,
                zorder=3,
                label="measured (light: late in the record)",
            )
    axes.axhline(0.0, lw=0.6, color="#6b7077")


def residual_figure(fit: Fit) -> Figure:
    """Plot residuals over speed, and their autocorrelation with the 95 % band of white noise."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.0))
        figure.subplots_adjust(left=0.08, right=0.99, bottom=0.16, top=0.97, wspace=0.2)
        left, right = figure.subplots(1, 2)
        longest = np.zeros(0)
        for record, predicted, residual in zip(
            fit.records, fit.predicted, fit.residuals, strict=True
        ):
            pick = _thin(len(predicted))
            left.plot(
                predicted[pick] / RPM,
                residual[pick] / RPM,
                ".",
                ms=2,
                color=MEASURED,
                rasterized=True,
            )
            used = residual[record.valid]
            longest = used if len(used) > len(longest) else longest
        left.set_xlabel("modelled speed (rpm)")
        left.set_ylabel("residual (rpm)")
        lags = max(1, min(60, len(longest) // 4))
        rho = autocorrelation(longest, lags)
        right.vlines(np.arange(1, lags + 1), 0.0, rho, color=MODEL, lw=1.2)
        for bound in (-1.96, 1.96):
            right.axhline(bound / np.sqrt(len(longest)), lw=0.8, ls="--", color=MARK)
        right.set_xlabel("lag (samples)")
        right.set_ylabel("autocorrelation of residuals")
    return figure
