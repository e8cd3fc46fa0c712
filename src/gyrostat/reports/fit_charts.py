"""Charts of records, fits and friction curves."""

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification import Fit
from gyrostat.identification.read.statistics import autocorrelation, crossing_times
from gyrostat.identification.torque_points import torque_points
from gyrostat.reports.axis import Axis, axis_of
from gyrostat.reports.chart import Chart
from gyrostat.reports.chart_frame import HEIGHT
from gyrostat.reports.page_units import BENCH_TORQUE
from gyrostat.reports.thinned import thinned
from gyrostat.telemetry import Record

MOST_SAMPLES, MOST_POINTS = 6000, 1200
"""Largest number of samples of a record, and of points of a curve."""
FACTOR, UNIT = BENCH_TORQUE
MOST_CROSSINGS = 200
"""Largest number of zero crossings that are marked."""
AGES = 5
"""Number of colours for the time of measured friction."""
LOW = 110
"""Height of a chart under another one with the same horizontal axis."""


def record_charts(
    record: Record,
    predicted: Vector,
    predicted_sigma: Vector | None,
    noise: float,
    group: str = "record",
) -> list[list[Markup]]:
    """Speed, current and residuals of a record over time, with zero crossings marked.

    Args:
        record: The measured record.
        predicted: Modelled speed, (N,), rad/s.
        predicted_sigma: Standard deviation of the modelled speed, (N,), rad/s, or None.
        noise: Standard deviation of the measured speed, rad/s.
        group: Name of the group of charts that are zoomed together.

    Returns:
        Columns of charts: speed and current; residuals.
    """
    time, crossings = record.time, crossing_times(record.time, predicted, noise)
    spread = np.zeros_like(predicted) if predicted_sigma is None else predicted_sigma
    limit = 2.0 * np.sqrt(spread**2 + noise**2) / RPM
    speed, model = record.speed / RPM, predicted / RPM
    across = Axis(float(time[0]), float(time[-1]), "time (s)")
    speed_axis = axis_of(np.concatenate([speed, model]), "")
    speeds = Chart(f"speed (rpm), zero crossings: {len(crossings)}", across, speed_axis)
    upright = axis_of(np.concatenate([speed - model, limit, -limit]), "")
    residuals = Chart("residual (rpm)", across, upright, height=HEIGHT + LOW)
    for chart, measured in ((speeds, speed), (residuals, speed - model)):
        _samples(chart, time, measured)
        for when in crossings[:MOST_CROSSINGS]:
            chart.level(when, "", "event", across=False)
        chart.level(0.0, "", "zero")
    speeds.line(*thinned(time, model, MOST_POINTS), "model")
    for sense, name in ((1.0, "upper limit"), (-1.0, "lower limit")):
        residuals.line(*thinned(time, sense * limit, MOST_POINTS), name)
    # a current is held until it changes
    changes = np.flatnonzero(np.diff(record.current)) + 1
    step_times = np.concatenate([time[:1], np.repeat(time[changes], 2), time[-1:]])
    current = np.repeat(record.current[[0, *changes]], 2)
    currents = Chart("current (A)", across, axis_of(current, ""), height=LOW)
    currents.line(*thinned(step_times, current, MOST_POINTS), "current")
    for chart in (speeds, currents, residuals):
        chart.attributes["group"] = group
    return [[speeds.svg(), currents.svg()], [residuals.svg()]]


def friction_charts(fit: Fit) -> list[list[Markup]]:
    """Friction curve with its 95 % band, and a histogram of the samples over speed below it.

    Args:
        fit: Result of an identification.

    Returns:
        Columns of charts: for the whole range of speeds, and near zero speed.
    """
    speeds = np.concatenate([r.speed[r.valid] for r in fit.records])
    reach = float(np.max(np.abs(speeds))) or 1.0
    scale = fit.parameters.get("stribeck_speed", 0.02 * reach)
    limits = (reach, min(8.0 * scale, reach))
    curves = _friction_curves(fit, limits)
    columns = []
    for limit, sides, where in zip(limits, curves, ("", " near zero speed"), strict=True):
        across = Axis(-1.03 * limit / RPM, 1.03 * limit / RPM, "speed (rpm)")
        curve = _friction_chart(fit, limit, sides, f"friction torque ({UNIT}){where}", across)
        ends = (-limit / RPM, limit / RPM)
        counts, edges = np.histogram(speeds / RPM, bins=60, range=ends)
        up = Axis(0.0, 1.05 * max(1.0, float(np.max(counts))), "")
        samples = Chart(f"samples{where}", across, up, height=LOW)
        samples.bars(edges, counts.astype(float))
        columns.append([curve.svg(), samples.svg()])
    return columns


def _friction_curves(fit: Fit, limits: Sequence[float]) -> list[list[tuple[Vector, ...]]]:
    """Speed, torque and sigma on both sides of zero for each limit, evaluated in one call."""
    half = np.linspace(1e-6, 1.0, 200)
    speeds = [np.sort(sense * half * limit) for limit in limits for sense in (-1.0, 1.0)]
    torque, sigma = (np.split(v, len(speeds)) for v in fit.friction_curve(np.concatenate(speeds)))
    sides = list(zip(speeds, torque, sigma, strict=True))
    return [sides[2 * k : 2 * k + 2] for k in range(len(limits))]


def _friction_chart(
    fit: Fit, limit: float, sides: Sequence[tuple[Vector, ...]], title: str, across: Axis
) -> Chart:
    points = fit.friction_points or torque_points(fit)
    near = np.zeros(0, int) if points is None else np.flatnonzero(np.abs(points.speed) <= limit)
    measured = [] if points is None else [points.speed / RPM, *_ends(points.torque, points.sigma)]
    measured = [values[near] for values in measured]
    bands = [_ends(torque, sigma) for _, torque, sigma in sides]
    extents = [*(end for band in bands for end in band), *measured[1:]]
    chart = Chart(title, across, axis_of(np.concatenate(extents), ""))
    for (speed, torque, _), (low, high) in zip(sides, bands, strict=True):
        fine = np.isfinite(low) & np.isfinite(high)
        chart.band(speed[fine] / RPM, low[fine], high[fine], "narrow")
        chart.line(speed / RPM, torque * FACTOR, "model")
    chart.level(0.0, "", "zero")
    if points is not None:
        when = np.ones(len(near)) if points.when is None else points.when[near]
        ages = np.minimum((AGES * when).astype(int), AGES - 1)
        for age in range(AGES):
            speed, low, high = (values[ages == age] for values in measured)
            chart.spans(speed, low, high, f"age{age}")
            chart.points(speed, 0.5 * (low + high), f"age{age}")
    return chart


def _ends(torque: Vector, sigma: Vector) -> tuple[Vector, Vector]:
    """Ends of 95 % intervals, in the unit of the charts, from torques and their sigmas, N·m."""
    return (torque - 2.0 * sigma) * FACTOR, (torque + 2.0 * sigma) * FACTOR


def residual_charts(fit: Fit) -> list[list[Markup]]:
    """Residuals over speed, and their autocorrelation with the 95 % band of white noise.

    Args:
        fit: Result of an identification.

    Returns:
        Columns of one chart each.
    """
    speed, residual = (np.concatenate(v) / RPM for v in (fit.predicted, fit.residuals))
    left = Chart("residual (rpm)", axis_of(speed, "modelled speed (rpm)"), axis_of(residual, ""))
    _samples(left, speed, residual)
    left.level(0.0, "", "zero")
    segments = [each[r.valid] for r, each in zip(fit.records, fit.residuals, strict=True)]
    longest = max(segments, key=len)
    lags = max(1, min(60, len(longest) // 4))
    rho, bound = autocorrelation(longest, lags), 1.96 / np.sqrt(len(longest))
    right = Chart(
        "autocorrelation of residuals",
        Axis(0.0, lags + 1.0, "lag (samples)"),
        axis_of(np.array([*rho, -bound, bound, 0.0]), ""),
    )
    right.spans(np.arange(1.0, lags + 1.0), np.minimum(rho, 0.0), np.maximum(rho, 0.0), "s0")
    for level, kind in ((0.0, "zero"), (-bound, "required"), (bound, "required")):
        right.level(level, "", kind)
    return [[left.svg()], [right.svg()]]


def _samples(chart: Chart, x: Vector, y: Vector) -> None:
    """Draw measured samples, at most about 6000 of them."""
    fine = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
    pick = fine[:: max(1, len(fine) // MOST_SAMPLES)]
    chart.points(x[pick], y[pick], "measured")
