"""The figures of the paper, drawn again from virtual records, and the scatter of the estimates."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat._jax import jax, jnp
from gyrostat._types import Matrix, Vector
from gyrostat.friction import Friction
from gyrostat.papers.carrara_kuga.printed import DETERMINISTIC, NAMES, STATISTICAL
from gyrostat.papers.carrara_kuga.virtual_bench import Prediction, Trial
from gyrostat.papers.reproduction import Drawing
from gyrostat.report.figures import BAND, MARK, MEASURED, MODEL, STYLE
from gyrostat.units import RPM

SYMBOLS = ("k_m", "b", "c", "T_s")
LABELS = ("$k_m$ (mN·m/A)", "$b$ (µN·m·s/rad)", "$c$ (mN·m)", "$T_s$ (mN·m)")
SCALES = np.array([1e3, 1e6, 1e3, 1e3])
"""From SI to the units of `LABELS`."""
TRUTH = np.array([getattr(STATISTICAL, name) for name in NAMES])
COLUMNS = "profile 1, sines", "profile 2, steps"
NEAR_ZERO = 16.0 * RPM
"""rad/s: four Stribeck speeds."""


def friction_drawing() -> Drawing:
    """Fig. 2: the friction curve of both columns of Table 1, whole and near zero speed."""
    wheels = (
        (STATISTICAL.friction(), MODEL, "statistical"),
        (DETERMINISTIC.friction(), MARK, "deterministic"),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.4), layout="constrained")
        whole, near = figure.subplots(1, 2)
        for axes, limit in ((whole, 200.0 * RPM), (near, NEAR_ZERO)):
            for friction, colour, label in wheels:
                _friction_axes(axes, friction, limit, colour, label)
            axes.axhline(0.0, lw=0.6, color="#6b7077")
            axes.set_xlabel("speed (rpm)")
            axes.set_ylabel("friction torque (mN·m)")
        whole.legend(loc="upper left")
        near.set_xlim(0.0, NEAR_ZERO / RPM)
        near.set_ylim(0.87, 0.91)
    return Drawing(
        "Friction torque (Fig. 2)",
        figure,
        "Both columns of Table 1; right, the Stribeck term near zero speed, 3 % of the Coulomb "
        "torque. The curve jumps by twice the static torque where the rotation reverses.",
    )


def _friction_axes(axes: Axes, friction: Friction, limit: float, colour: str, label: str) -> None:
    half = jnp.linspace(0.0, limit, 400)
    for sense in (-1.0, 1.0):
        torque = jax.vmap(friction.torque, (0, None))(sense * half, sense)
        own = label if sense > 0.0 else None
        axes.plot(
            sense * np.asarray(half) / RPM,
            1e3 * np.asarray(torque),
            color=colour,
            lw=1.3,
            label=own,
        )


def profiles_drawing(trial: Trial) -> Drawing:
    """Fig. 3: commanded current and measured speed."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.2), layout="constrained")
        grid = figure.subplots(2, 2, sharex=True, height_ratios=[1.0, 1.6])
        for column, prediction in enumerate((trial.profile1, trial.profile2)):
            record = prediction.record
            top, bottom = grid[0, column], grid[1, column]
            top.step(record.time, 1e3 * record.current, where="post", lw=0.9, color="#444a52")
            top.set_title(COLUMNS[column], fontsize=9)
            _points(bottom, record.time, record.speed, "measured")
            bottom.axhline(0.0, lw=0.6, color="#6b7077")
            bottom.set_xlabel("time (s)")
        grid[0, 0].set_ylabel("current (mA)")
        grid[1, 0].set_ylabel("speed (rpm)")
        figure.align_ylabels(grid[:, 0])
    return Drawing(
        "The two profiles (Fig. 3)",
        figure,
        "One virtual record of each. The Coulomb torque bends the speed where it passes zero.",
    )


def speeds_drawing(trial: Trial) -> Drawing:
    """Figs. 4 and 5: measured speed and both models."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.4), layout="constrained")
        pairs = zip(figure.subplots(2, 1), (trial.profile1, trial.profile2), COLUMNS, strict=True)
        for axes, prediction, title in pairs:
            record = prediction.record
            _points(axes, record.time, record.speed, "measured")
            for speed, colour, label in (
                (prediction.deterministic, MARK, "deterministic"),
                (prediction.statistical, MODEL, "statistical (estimated)"),
            ):
                axes.plot(record.time, speed / RPM, lw=1.2, color=colour, label=label)
            axes.set_title(title, fontsize=9)
            axes.set_xlabel("time (s)")
            axes.set_ylabel("speed (rpm)")
            axes.legend(loc="upper right", ncols=3)
            axes.margins(y=0.18)
    return Drawing(
        "Deterministic and statistical model (Figs. 4 and 5)",
        figure,
        "The estimate from profile 2, and the deterministic column with T_s = c.",
    )


def residuals_drawing(trial: Trial) -> Drawing:
    """Fig. 6: measured speed above, residuals of both models below."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 4.6), layout="constrained")
        grid = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=[1.0, 1.4])
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
        "virtual wheel has no friction that eq. (1) does not have.",
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


def scatter_drawing(trials: Sequence[Trial]) -> Drawing:
    """Estimates over the seeds against their formal uncertainty."""
    estimates = np.array([trial.error for trial in trials]) + TRUTH
    covariances = np.array([trial.covariance for trial in trials])
    sigmas = np.sqrt(np.diagonal(covariances, axis1=1, axis2=2))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.2), layout="constrained")
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.7, 1.0]).ravel()
        for axes, pair in zip(top.subplots(1, 2), ((0, 1), (2, 3)), strict=True):
            _ellipse_axes(axes, estimates, covariances.mean(axis=0), pair)
        for k, axes in enumerate(bottom.subplots(1, 4, sharey=True)):
            _histogram_axes(axes, (estimates[:, k] - TRUTH[k]) / sigmas[:, k], SYMBOLS[k])
    return Drawing(
        f"Estimates over {len(trials)} records",
        figure,
        "Above, estimates with the 1 and 2 sigma ellipses of the mean formal covariance about the "
        "truth (39 % and 86 % of normal errors fall inside). Below, errors over their own formal "
        "sigma beside the normal density.",
    )


def _ellipse_axes(axes: Axes, estimates: Matrix, covariance: Matrix, pair: tuple[int, int]) -> None:
    index = list(pair)
    scale = SCALES[index]
    points, centre = estimates[:, index] * scale, TRUTH[index] * scale
    axes.plot(*points.T, ".", ms=4, color=MEASURED, label="estimates")
    root = np.linalg.cholesky(covariance[np.ix_(index, index)]) * scale[:, None]
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = root @ np.array([np.cos(turn), np.sin(turn)])
    for reach in (1.0, 2.0):
        ring = centre[:, None] + reach * circle
        label = "formal, 1 and 2 sigma" if reach == 1.0 else None
        axes.plot(*ring, color=MODEL, lw=1.2, label=label)
    axes.plot(*centre, "+", ms=11, mew=2.0, color=MARK, label="truth")
    axes.set_xlabel(LABELS[pair[0]])
    axes.set_ylabel(LABELS[pair[1]])
    axes.ticklabel_format(useOffset=False)
    axes.locator_params(axis="x", nbins=5)
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3)


def _histogram_axes(axes: Axes, errors: Vector, symbol: str) -> None:
    edges = np.linspace(-4.0, 4.0, 25)
    axes.hist(errors, bins=edges.tolist(), density=True, color=BAND)
    grid = np.linspace(-4.0, 4.0, 200)
    axes.plot(grid, np.exp(-0.5 * grid**2) / np.sqrt(2.0 * np.pi), color=MODEL, lw=1.2)
    axes.set_xlabel(f"error of ${symbol}$ (sigma)")
