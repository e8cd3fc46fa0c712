"""Pages and pictures of a fitted waterfall and of the motion of the line of sight."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.files import write_texts
from gyrostat.core.outputs import new_files
from gyrostat.core.units import RPM
from gyrostat.microvibration.disturbance_file import disturbance_text
from gyrostat.microvibration.model import DENSITY_UNITS, TWO_PI
from gyrostat.microvibration.result import WaterfallFit
from gyrostat.microvibration.sight import LineOfSight
from gyrostat.microvibration.sight_text import ARCSEC, bands_text, content, text_lines
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.figure_charts import figure_charts
from gyrostat.reports.template import render
from gyrostat.spacecraft.wheel_modes import whirl_frequencies

WATERFALL_FILES = ("disturbance.json", "disturbance.toml", "waterfall.html")
SIGHT_FILES = ("jitter.json", "bands.toml", "jitter.html")
TITLES = {"force": "Fx, Fy", "axial": "Fz", "torque": "Tx, Ty", "torsion": "Tz"}
RANGE = 60.0
"""Range of the colours below the largest density, dB."""
HEIGHT = 3.2


def waterfall_figure(result: WaterfallFit) -> Figure:
    """Draw the density of each kind of load over speed, with harmonics and modes.

    Args:
        result: Fit of a waterfall.
    """
    kinds = list(result.waterfall.kinds)
    with panels(len(kinds), height=HEIGHT * len(kinds), squeeze=False) as (figure, grid):
        for axes, kind in zip(grid[:, 0], kinds, strict=True):
            _waterfall(axes, result, kind)
        grid[-1, 0].set_xlabel("frequency (Hz)")
    return figure


def _waterfall(axes: Axes, result: WaterfallFit, kind: str) -> None:
    data = result.waterfall
    density = data.kinds[kind][0]
    speed, frequency = data.speed / RPM, data.frequency
    level = 10.0 * np.log10(np.maximum(density, 10.0 ** (-RANGE / 10.0) * density.max()))
    image = axes.pcolormesh(
        frequency, speed, level, shading="nearest", cmap="viridis", rasterized=True
    )
    axes.figure.colorbar(image, ax=axes).set_label(f"dB of {DENSITY_UNITS[kind]}")
    axes.grid(visible=False)
    for harmonic in result.harmonics:
        if not harmonic.coefficients[kind].total.observable:
            continue
        line = harmonic.number.value * data.speed / TWO_PI
        axes.plot(line, speed, color="white", lw=0.6, ls=":")
        # on the line, at nine tenths of the way that is shown
        at = int(0.9 * np.searchsorted(line, frequency[-1]))
        box = {"facecolor": "black", "alpha": 0.6, "linewidth": 0, "pad": 1.5}
        label = f"{harmonic.number.value:.3g}"
        place = {"ha": "center", "va": "center", "clip_on": True}
        axes.text(line[at], speed[at], label, color="white", fontsize=8, bbox=box, **place)
    mode = result.kinds[kind].mode if kind in result.kinds else {}
    if mode:
        ratio = mode["inertia_ratio"].value if "inertia_ratio" in mode else 0.0
        for line in whirl_frequencies(data.speed, mode["frequency"].value, ratio):
            axes.plot(line / TWO_PI, speed, color=MARK, lw=1.2, ls="--")
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_ylim(speed[0], speed[-1])
    axes.set_ylabel("speed (rpm)")
    axes.set_title(f"{TITLES[kind]}, {literal(data.name)}", fontsize=9, loc="left")


def sight_figure(result: LineOfSight) -> Figure:
    """Draw smear and jitter of the line of sight over the speed of each wheel.

    Args:
        result: Motion of the line of sight.
    """
    speed = result.speed / RPM
    rms = result.rms() / ARCSEC
    parts = [result.rms(name) / ARCSEC for name in ("smear", "jitter")]
    bands = result.bands()
    count = len(result.wheels)
    with panels(count, height=2.3 * count, squeeze=False, sharex=True) as (figure, grid):
        for axes, wheel, total, smear, jitter in zip(
            grid[:, 0], result.wheels, rms, *parts, strict=True
        ):
            for low, high in bands:
                axes.axvspan(low / RPM, high / RPM, color=BAND, alpha=0.5, lw=0)
            axes.plot(speed, total, color=MODEL, lw=1.3, label="smear and jitter")
            axes.plot(speed, jitter, color=MEASURED, lw=0.8, label="jitter")
            axes.plot(speed, smear, color=MEASURED, lw=0.8, ls="--", label="smear")
            if result.limit is not None:
                share = result.limit / np.sqrt(count) / ARCSEC
                axes.axhline(share, color=MARK, lw=1.0, label="share of the limit")
            axes.set_yscale("log")
            axes.set_ylim(bottom=max(total.max() * 1e-4, total[total > 0.0].min(initial=1.0)))
            axes.set_ylabel("rms (arcsec)")
            axes.set_title(literal(wheel.name), fontsize=9, loc="left")
        entries = grid[0, 0].get_legend_handles_labels()
        figure.legend(*entries, ncols=4, fontsize=8, loc="outside upper left")
        grid[-1, 0].set_xlabel("wheel speed (rpm)")
    return figure


def write_waterfall(
    result: WaterfallFit, out: Path, *, command: str, say: Callable[[str], None], force: bool
) -> None:
    """Write disturbance.json and waterfall.html, and disturbance.toml of a valid result.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    page = render(
        "microvibration.html",
        title="Waterfall",
        command=command,
        lines=result.lines(),
        invalid=result.reasons,
        figure=figure_charts(waterfall_figure(result)),
        caption="Density of the loads. Dotted: harmonics with their number. Broken: modes; the "
        "speed splits a rocking mode into two whirls.",
    )
    files = {"disturbance.json": _json(result.content()), "waterfall.html": page}
    if result.valid:
        files["disturbance.toml"] = disturbance_text(result.disturbance())
    _write(files, out, "waterfall", say, force)


def write_sight(
    result: LineOfSight,
    detail: float | None,
    out: Path,
    *,
    command: str,
    say: Callable[[str], None],
    force: bool,
) -> None:
    """Write jitter.json, jitter.html and bands.toml, sections of a scenario.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    page = render(
        "microvibration.html",
        title="Line of sight over wheel speed",
        command=command,
        lines=text_lines(result, detail),
        invalid=(),
        figure=figure_charts(sight_figure(result)),
        caption="Motion in an exposure by each wheel alone, both axes. Bands: speeds at which a "
        "wheel exceeds its share of the limit.",
    )
    files = {
        "jitter.json": _json(content(result, detail)),
        "jitter.html": page,
        "bands.toml": bands_text(result),
    }
    _write(files, out, "jitter", say, force)


def _json(value: dict[str, Any]) -> str:
    return json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _write(
    files: dict[str, str], out: Path, by: str, say: Callable[[str], None], force: bool
) -> None:
    with new_files(out, by=by, force=force) as folder:
        write_texts(folder, files)
    say(f"written: {', '.join(str(out / name) for name in files)}")
