"""Pictures of records, wheel models, friction along telemetry, and a rehearsed monitor."""

import numpy as np
from matplotlib.figure import Figure

from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.units import RPM
from gyrostat.estimation.track import FrictionTrack
from gyrostat.monitoring.rehearsal import Rehearsal
from gyrostat.reports.colours import BAND, MARK, MEASURED, MODEL
from gyrostat.reports.drawing import literal, panels
from gyrostat.reports.page_units import BENCH_TORQUE
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction
from gyrostat.wheel.model_file import WheelModel

HEIGHT = 1.9
"""Height of a panel, inches."""
CURVE = 200
"""Points of a friction curve on each side of zero speed."""
USUAL_SPEED = 3000.0 * RPM
"""Reach of the curve of a wheel without viscous friction, rad/s."""


def record_figure(record: Record) -> Figure:
    """Draw the columns of a record over time.

    Args:
        record: Record.
    """
    factor, unit = BENCH_TORQUE
    rows = [("speed (rpm)", record.speed / RPM), ("current (A)", record.current)]
    if record.torque is not None:
        rows.append((f"torque ({unit})", factor * record.torque))
    if record.temperature is not None:
        rows.append(("temperature (°C)", record.temperature))
    height = HEIGHT * len(rows)
    with panels(len(rows), height=height, sharex=True, squeeze=False) as (figure, grid):
        for axes, (label, values) in zip(grid[:, 0], rows, strict=True):
            axes.plot(record.time, values, ".", ms=2, color=MEASURED, rasterized=True)
            axes.set_ylabel(label)
        grid[0, 0].set_title(literal(record.name), fontsize=9)
        grid[-1, 0].set_xlabel("time (s)")
    return figure


def track_figure(track: FrictionTrack) -> Figure:
    """Draw the friction with its 95 % band over time, above the speed.

    Args:
        track: Result of the filter.
    """
    with panels(2, height=2 * HEIGHT, sharex=True) as (figure, (upper, lower)):
        width = 2.0 * track.scale_sigma
        ends = track.scale - width, track.scale + width
        upper.fill_between(track.time, *ends, color=BAND, alpha=0.6, lw=0, label="95 %")
        upper.plot(track.time, track.scale, color=MODEL, lw=1.2)
        upper.axhline(1.0, color=MARK, lw=0.6)
        settled = track.scale[len(track.time) // 10 :]  # the first values are those of the start
        sizes = np.append(np.abs(settled - 1.0), 3.0 * track.scale_sigma[-1:])
        reach = 1.3 * max([*sizes[np.isfinite(sizes)], 1e-3])
        upper.set_ylim(1.0 - reach, 1.0 + reach)
        upper.set_ylabel("friction over\nthat of the model")
        upper.legend(loc="upper right")
        lower.plot(track.time, track.speed / RPM, color=MEASURED, lw=0.8)
        lower.set_ylabel("speed (rpm)")
        lower.set_xlabel("time (s)")
    return figure


def model_figure(model: WheelModel) -> Figure:
    """Draw the friction curve of a model; of bristles, that of steady rotation.

    Args:
        model: Wheel model.
    """
    law = model.friction.of(**{name: model.values[name] for name in model.friction.dimensions()})
    curve = law if isinstance(law, Friction) else law.curve
    viscous, (factor, unit) = float(model.values.get("viscous", 0.0)), BENCH_TORQUE
    # viscous friction is there 1.5 times that at rest
    rest = abs(float(curve.torque(0.0, 1.0)))
    reach = 1.5 * rest / viscous if rest > 0.0 and viscous > 0.0 else USUAL_SPEED
    half = np.linspace(1e-6, 1.0, CURVE) ** 2 * reach
    with panels(height=1.4 * HEIGHT) as (figure, axes):
        for direction in (-1.0, 1.0):
            torque = jax.vmap(curve.torque, (0, None))(jnp.asarray(direction * half), direction)
            axes.plot(direction * half / RPM, factor * np.asarray(torque), color=MODEL, lw=1.4)
        axes.axvline(0.0, color=MARK, lw=0.6)
        axes.set_xlabel("speed (rpm)")
        axes.set_ylabel(f"friction ({unit})")
    return figure


def rehearsal_figure(rehearsal: Rehearsal) -> Figure:
    """Draw for each fault the wheels with an alarm and with the right class, and the delay.

    Args:
        rehearsal: Result of a rehearsal.
    """
    names, faults = [*rehearsal.faults], [*rehearsal.faults.values()]
    place = np.arange(len(names))
    height = max(HEIGHT, 0.9 + 0.35 * len(names))
    with panels(1, 2, height=height, sharey=True) as (figure, (left, right)):
        alarms, found, among = (
            np.array([100.0 * getattr(each, name) / each.wheels for each in faults])
            for name in ("alarms", "right", "among")
        )
        left.barh(place - 0.2, alarms, height=0.36, color=MODEL, label="alarm")
        left.barh(place + 0.2, found, height=0.36, color=MEASURED, label="class right")
        left.barh(place + 0.2, among, left=found, height=0.36, color=BAND, label="of two or three")
        left.set_xlim(0.0, 100.0)
        left.set_xlabel("wheels (%)")
        left.set_yticks(place, [literal(name) for name in names])
        left.invert_yaxis()
        left.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)
        delays = [each.delay if np.isfinite(each.delay) else 0.0 for each in faults]
        right.barh(place, delays, height=0.5, color=MEASURED)
        for row, each in enumerate(faults):
            if not np.isfinite(each.delay):
                right.text(0.0, row, " none", va="center")
        right.set_xlabel("median delay of the alarm (days)")
    return figure
