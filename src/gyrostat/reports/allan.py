"""Files and picture of the Allan deviations of a gyro."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gyrostat.core.outputs import new_files
from gyrostat.identification.gyro.fit import AxisNoise
from gyrostat.identification.gyro.noise import NAMES, allan_variances
from gyrostat.identification.gyro.parameters import PARAMETERS
from gyrostat.identification.gyro.result import DEGREES_PER_HOUR, GyroNoise
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels, svg

FILES = ("allan.json", "allan.svg", "sensors.toml")
HEIGHT = 3.4
"""Height of the panel of an axis, inches."""


def allan_figure(result: GyroNoise) -> Figure:
    """Draw the Allan deviation of each axis with its intervals, the fit and its parts.

    Args:
        result: Result of `allan`.
    """
    rows = len(result.axes)
    with panels(rows, height=HEIGHT * rows, squeeze=False) as (figure, grid):
        for axes, each in zip(grid[:, 0], result.axes, strict=True):
            _axis(axes, each)
        grid[0, 0].set_title(literal(result.name), fontsize=9, loc="left")
        grid[-1, 0].set_xlabel("averaging time (s)")
    return figure


def _axis(axes: Axes, noise: AxisNoise) -> None:
    """Draw one axis."""
    time, scale = noise.time, DEGREES_PER_HOUR
    parameters = [noise.parameters[name] for name in NAMES]
    parts = [
        each.value**2 * row for each, row in zip(parameters, allan_variances(time), strict=True)
    ]
    ramp = noise.parameters["rate_ramp"]
    parts.append(0.5 * (ramp.value * time) ** 2)
    total = np.sqrt(np.sum(parts, axis=0))
    axes.fill_between(
        time, scale * noise.low, scale * noise.high, color=BAND, alpha=0.6, lw=0, label="95 %"
    )
    axes.plot(time, scale * noise.deviation, ".", ms=4, color=MEASURED, label="record")
    axes.plot(time, scale * total, lw=1.3, color=MODEL, label="fit")
    shown = scale * noise.deviation.min() * 0.3
    for each, part in zip([*parameters, ramp], parts, strict=True):
        if each.observable:
            deviation = scale * np.sqrt(part)
            axes.plot(time, deviation, lw=0.8, ls="--", color=MARK)
            k = int(np.argmax(deviation * (deviation < 3.0 * scale * total)))
            axes.annotate(
                PARAMETERS[each.name].letter, (time[k], deviation[k]), color=MARK, fontsize=8
            )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(bottom=shown)
    axes.set_ylabel(f"Allan deviation, {noise.axis} (deg/h)")
    axes.legend(loc="upper right", ncols=3)


def write_allan(
    result: GyroNoise, out: Path, *, say: Callable[[str], None], force: bool = False
) -> None:
    """Write allan.json, allan.svg and sensors.toml.

    Args:
        result: Result of `allan`.
        out: Output folder.
        say: Called with the line that names the files.
        force: Whether to replace files that `allan` did not write; see `gyrostat.core.outputs`.

    Raises:
        InputError: A file of the user is in the way, or the folder cannot be written.
    """
    text = json.dumps(result.content(), indent=1, ensure_ascii=False, allow_nan=False)
    picture = svg(allan_figure(result))
    with new_files(out, by="allan", force=force) as folder:
        (folder / "allan.json").write_text(text + "\n", encoding="utf-8")
        (folder / "allan.svg").write_text(picture, encoding="utf-8")
        (folder / "sensors.toml").write_text(result.sensors(), encoding="utf-8")
    say(f"written: {', '.join(str(out / name) for name in FILES)}")
