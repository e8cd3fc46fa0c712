"""Pictures of results for `plot()` and for notebooks."""

from base64 import b64encode
from functools import singledispatch
from html import escape

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.pictured_datasets import Run, Runs
from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.estimation.track import FrictionTrack
from gyrostat.failures import Holdable, Recovery
from gyrostat.identification import Fit, Validation
from gyrostat.identification.bench_tests.plan import TestPlan
from gyrostat.identification.bench_tests.verdict import BenchVerdict
from gyrostat.identification.experiment.design import Design
from gyrostat.identification.gyro.result import GyroNoise
from gyrostat.identification.judge.fit_changes import Comparison
from gyrostat.identification.lot.result import Lot
from gyrostat.identification.pool.result import Pool
from gyrostat.identification.torque_points import torque_points
from gyrostat.identification.uncertainty.posterior import Posterior
from gyrostat.microvibration.result import WaterfallFit
from gyrostat.microvibration.sight import LineOfSight
from gyrostat.monitoring.health import Health
from gyrostat.monitoring.rehearsal import Rehearsal
from gyrostat.reports.allan import allan_figure
from gyrostat.reports.bench_tests import plan_figure as test_plan_figure
from gyrostat.reports.bench_tests import verdict_figure
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.comparison import comparison_figure
from gyrostat.reports.datasets import run_figure, runs_figure
from gyrostat.reports.design import design_figure
from gyrostat.reports.drawing import literal, panels, png
from gyrostat.reports.error_budget import budget_figure
from gyrostat.reports.failure_pictures import holdable_figure, recovery_figure
from gyrostat.reports.health_picture import health_figure
from gyrostat.reports.input_pictures import (
    model_figure,
    record_figure,
    rehearsal_figure,
    track_figure,
)
from gyrostat.reports.lot import histograms
from gyrostat.reports.microvibration import sight_figure, waterfall_figure
from gyrostat.reports.page_units import BENCH_TORQUE
from gyrostat.reports.placement_picture import placement_figure
from gyrostat.reports.pool import over_conditions
from gyrostat.reports.posterior import posterior_picture
from gyrostat.reports.speed_plan_charts import plan_figure as speed_plan_figure
from gyrostat.reports.tuning import tuning_figure
from gyrostat.runs.placement_result import Placement
from gyrostat.search.budget_result import ErrorBudget
from gyrostat.search.speed_plan import SpeedPlan
from gyrostat.search.tuning import TunedGains
from gyrostat.telemetry import Record
from gyrostat.wheel.model_file import WheelModel

HEIGHT = 2.1
"""Height of a panel, inches."""
MOST_RECORDS = 3
"""Largest number of records that are drawn."""
CURVE = 400
"""Number of points of a friction curve."""


def notebook_html(result: object) -> str:
    """Text and picture of a result.

    Args:
        result: Result with a picture.
    """
    return text_and_picture(str(result), picture(result), type(result).__name__)


def text_and_picture(text: str, figure: Figure, name: str) -> str:
    """HTML of a text and a figure.

    Args:
        text: Text.
        figure: Figure.
        name: Description of the figure.
    """
    image = b64encode(png(figure)).decode()
    return (
        f"<pre>{escape(text)}</pre>\n"
        f'<img alt="{name}" style="max-width: 100%" '
        f'src="data:image/png;base64,{image}">'
    )


@singledispatch
def picture(result: object) -> Figure:
    """Draw a result.

    Args:
        result: Result of a verb.

    Raises:
        TypeError: There is no picture of its class.
    """
    raise TypeError(f"found no picture of {type(result).__name__}, expected a result of a verb")


@picture.register
def _(result: Fit) -> Figure:
    """Speed and residual of each record, and the friction curve."""
    shown = list(zip(result.records, result.predicted, result.predicted_sigma, strict=False))
    shown = shown[:MOST_RECORDS]
    with panels(2 * len(shown) + 1, height=HEIGHT * (2 * len(shown) + 1), squeeze=False) as (
        figure,
        grid,
    ):
        rows = grid[:, 0].tolist()
        for k, (record, predicted, sigma) in enumerate(shown):
            noise = result.speed_sigmas[k]
            _speeds(rows[2 * k : 2 * k + 2], record, predicted, sigma, noise)
        _friction(rows[-1], result)
    return figure


@picture.register
def _(result: Validation) -> Figure:
    """Measured and predicted speed of a record, and their difference."""
    with panels(2, height=2 * HEIGHT, sharex=True) as (figure, axes):
        _speeds(axes, result.record, result.predicted, result.predicted_sigma, result.noise)
    return figure


picture.register(Comparison, comparison_figure)
picture.register(Design, design_figure)
picture.register(GyroNoise, allan_figure)
picture.register(ErrorBudget, budget_figure)
picture.register(Health, health_figure)
picture.register(LineOfSight, sight_figure)
picture.register(Lot, histograms)
picture.register(Pool, over_conditions)
picture.register(WaterfallFit, waterfall_figure)
picture.register(Placement, placement_figure)
picture.register(SpeedPlan, speed_plan_figure)
picture.register(TestPlan, test_plan_figure)
picture.register(BenchVerdict, verdict_figure)
picture.register(TunedGains, tuning_figure)
picture.register(Run, run_figure)
picture.register(Runs, runs_figure)
picture.register(Holdable, holdable_figure)
picture.register(Recovery, recovery_figure)
picture.register(Record, record_figure)
picture.register(WheelModel, model_figure)
picture.register(FrictionTrack, track_figure)
picture.register(Rehearsal, rehearsal_figure)
picture.register(Posterior, posterior_picture)


def _speeds(
    axes: "list[Axes]", record: Record, predicted: Vector, sigma: Vector, noise: float
) -> None:
    """Speed of a record above its residual with the 95 % interval.

    Args:
        axes: Upper and lower panel.
        record: Measured record.
        predicted: Modelled speed, (N,), rad/s.
        sigma: Its standard deviation, (N,), rad/s.
        noise: Standard deviation of the measured speed, rad/s.
    """
    upper, lower = axes
    limit = 2.0 * np.hypot(sigma, noise) / RPM
    samples = {"ls": "none", "marker": ".", "ms": 2, "color": MEASURED, "rasterized": True}
    upper.plot(record.time, record.speed / RPM, **samples, label="measured")
    upper.plot(record.time, predicted / RPM, lw=1.0, color=MODEL, label="model")
    upper.set_title(literal(record.name), fontsize=9)
    upper.set_ylabel("speed (rpm)")
    upper.legend(loc="upper right")
    lower.fill_between(record.time, -limit, limit, color=BAND, alpha=0.5, lw=0, label="95 %")
    lower.plot(record.time, (record.speed - predicted) / RPM, **samples)
    lower.set_ylabel("residual (rpm)")
    lower.set_xlabel("time (s)")
    lower.legend(loc="upper right")


def _friction(axes: Axes, fit: Fit) -> None:
    """Friction curve with its 95 % interval, and the measured torques."""
    factor, unit = BENCH_TORQUE
    points = fit.friction_points or torque_points(fit)
    speeds = [np.abs(r.speed[r.valid]) for r in fit.records]
    speeds += [] if points is None else [np.abs(points.speed)]
    reach = max((float(np.max(each)) for each in speeds), default=0.0) or 1.0
    half = np.linspace(1e-6, 1.0, CURVE) ** 2 * reach
    if points is not None:
        torque, sigma = factor * points.torque, 2.0 * factor * points.sigma
        axes.errorbar(
            points.speed / RPM, torque, yerr=sigma, fmt=".", ms=3, lw=0.7, color=MEASURED, zorder=1
        )
    for speed in (-half[::-1], half):
        torque, sigma = (factor * values for values in fit.friction_curve(speed))
        ends = (torque - 2.0 * sigma, torque + 2.0 * sigma)
        axes.fill_between(speed / RPM, *ends, color=BAND, alpha=0.7, lw=0)
        axes.plot(speed / RPM, torque, color=MODEL, lw=1.2)
    axes.axvline(0.0, color=MARK, lw=0.6)
    axes.set_xlabel("speed (rpm)")
    axes.set_ylabel(f"friction ({unit})")
