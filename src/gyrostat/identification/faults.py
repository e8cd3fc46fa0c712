"""Faults of measurement that show in the samples themselves: outliers, pulse counters, units."""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.findings import Finding
from gyrostat.identification.loss import Loss, Quadratic
from gyrostat.identification.signs import lost_sign
from gyrostat.identification.statistics import NORMAL_MAD, quantum
from gyrostat.telemetry import Record

OUTLYING = 5.0
"""Standard deviations of the noise from which a sample that stands out of its neighbours is an
outlier: one in two million of normal noise."""
NEIGHBOURS = 5
"""Samples whose median a sample is compared with."""
COARSE = 1.0
"""Step of a quantised speed, over the scatter of the residuals, from which it is named."""
WHOLE = 0.02
"""Share by which the pulses a turn of a counter may differ from a whole number."""

FASTEST = 1500.0
"""rad/s: 14 000 rpm, beyond any ball-bearing reaction wheel."""
LARGEST_CURRENT, SMALLEST_CURRENT = 50.0, 1e-3
"""A: beyond any reaction wheel drive, and below what turns any."""
BACK_EMF = 60.0
"""V: motors of reaction wheels run on 5 to 50 V, and must overcome their own back-EMF."""
MOTOR_CONSTANTS = (5e-4, 0.14)
"""N·m/A: from the smallest cubesat wheels to motors that a 28 V bus stops at 2000 rpm."""
WEAKEST = 0.005
"""N·m/A at 1e-3 kg·m²: a fourth of the usual motor constant of a flywheel of this inertia."""
GROWTH = 0.4
"""Exponent with which the usual motor constant grows with the inertia of the flywheel."""

SPEED_FACTORS = {
    "rpm read as rad/s": RPM,
    "rad/s read as rpm": 1.0 / RPM,
    "rev/s read as rad/s": 2.0 * np.pi,
    "rad/s read as rev/s": 0.5 / np.pi,
    "deg/s read as rad/s": np.pi / 180.0,
    "rad/s read as deg/s": 180.0 / np.pi,
}
"""Slip of units -> true over recorded speed."""
CURRENT_FACTORS = {"mA read as A": 1e-3, "A read as mA": 1e3}
"""Slip of units -> true over recorded current."""


def outliers(record: Record, residual: Vector) -> Finding | None:
    """Single speeds far from their neighbours.

    Args:
        record: Of the samples.
        residual: (N,) measured minus modelled speed, rad/s; NaN where missing.
    """
    used = residual[record.valid]
    if len(used) < 4 * NEIGHBOURS:
        return None
    padded = np.pad(used, NEIGHBOURS // 2, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS)
    around = np.median(np.delete(windows, NEIGHBOURS // 2, axis=1), axis=1)
    apart = used - around
    # the median of the neighbours is noisy too
    level = NORMAL_MAD * float(np.median(np.abs(apart)))
    step = quantum(record.speed[record.valid]) or 0.0
    z = np.abs(apart) / max(level, step, np.finfo(float).tiny)
    far = z > OUTLYING
    if level == 0.0 or not far.any():
        return None
    count = int(far.sum())
    evidence = float(np.sum(z[far] ** 2 - 2.0 * np.log(len(used))))
    return Finding(
        names=("outliers",),
        titles=(f"outliers in the speed of {record.name}, share of the samples",),
        value=count / len(used),
        sigma=None,
        unit="1",
        significance=float(z.max()),
        evidence=evidence,
    )


def counter(record: Record, residual: Vector) -> Finding | None:
    """A coarse step of the speed, as a pulse counter has.

    Args:
        record: Of the samples.
        residual: (N,) measured minus modelled speed, rad/s; NaN where missing.
    """
    speeds = record.speed[record.valid]
    step = quantum(speeds)
    scatter = float(np.std(residual[record.valid]))
    if step is None or step < COARSE * scatter:
        return None
    gate = float(np.median(np.diff(record.time)))
    pulses = 2.0 * np.pi / (step * gate)
    whole = round(pulses)
    title = f"quantised speed of {record.name} (step {step / RPM:.4g} rpm)"
    if whole >= 1 and abs(pulses - whole) < WHOLE * whole:
        title += f": a pulse counter with {whole} a turn over a gate of {gate:.3g} s"
    return Finding(
        names=("quantum",),
        titles=(title,),
        value=step,
        sigma=None,
        unit="rad/s",
        significance=float(np.sqrt(len(speeds))),
        evidence=float(len(speeds)),
    )


def implausible(
    motor_constant: float | None, inertia: float | None, speed: float, current: float
) -> list[str]:
    """Why no reaction wheel has these values; empty where one may.

    Args:
        motor_constant: N·m/A, estimated; None where it was not.
        inertia: kg·m², or None.
        speed: Largest, rad/s.
        current: Largest, A.
    """
    motor = abs(motor_constant or 0.0)
    found = []
    if speed > FASTEST:
        found.append(f"the wheel reaches {speed:.0f} rad/s = {speed / RPM:.0f} rpm")
    if motor * speed > BACK_EMF:
        found.append(
            f"k_m times the largest speed is a back-EMF of {motor * speed:.0f} V, above any "
            "wheel's supply"
        )
    if current > LARGEST_CURRENT:
        found.append(f"the current reaches {current:.0f} A")
    elif 0.0 < current < SMALLEST_CURRENT:
        found.append(f"the current reaches only {current:.3g} A")
    low, high = MOTOR_CONSTANTS
    if motor_constant is not None:
        if inertia is not None:
            low = max(low, WEAKEST * (inertia / 1e-3) ** GROWTH)
        if not low <= motor <= high:
            found.append(f"k_m = {motor:.3g} N·m/A lies outside {low:.2g} to {high:g}")
    return found


def wrong_units(
    parameters: Mapping[str, float], estimated: Sequence[str], records: Sequence[Record]
) -> Finding | None:
    """Slips of units that would make an implausible wheel plausible.

    Args:
        parameters: Name -> value of estimated and held ones, SI.
        estimated: Names of the estimated ones.
        records: Of the fit.
    """
    speed = max(float(np.nanmax(np.abs(r.speed))) for r in records)
    current = max(float(np.max(np.abs(r.current))) for r in records)
    motor = parameters.get("motor_constant") if "motor_constant" in estimated else None
    inertia = None if "inertia" in estimated else parameters.get("inertia")
    why = implausible(motor, inertia, speed, current)
    if not why:
        return None

    def cures(of_speed: float, of_current: float) -> bool:
        scaled = None if motor is None else motor * of_speed / of_current
        return not implausible(scaled, inertia, of_speed * speed, of_current * current)

    slips = [slip for slip, factor in SPEED_FACTORS.items() if cures(factor, 1.0)]
    slips += [slip for slip, factor in CURRENT_FACTORS.items() if cures(1.0, factor)]
    cause = f"most likely {' or '.join(slips)}" if slips else "no single slip explains it"
    title = f"implausible units: {'; '.join(why)}; {cause}"
    return certain("units", title)


def opposed_signs(motor_constant: float, sigma: float) -> Finding | None:
    """A motor constant below zero: one of current and speed has the wrong sign.

    Args:
        motor_constant: N·m/A.
        sigma: Its standard deviation, N·m/A.
    """
    if motor_constant >= -2.0 * sigma:
        return None
    return certain("opposed_signs", "current and speed of opposite senses")


def certain(name: str, title: str) -> Finding:
    """A finding that physics tells.

    Args:
        name: Identifier.
        title: What a report calls it.
    """
    return Finding((name,), (title,), 1.0, None, "1", None, None)


def found_in(record: Record, residual: Vector, loss: Loss) -> list[Finding]:
    """Faults of measurement that show in the samples of one record.

    Args:
        record: Of the samples.
        residual: (N,) measured minus modelled speed, rad/s; NaN where missing.
        loss: Of the fit; a robust one forgives outliers, which are then no finding.
    """
    seen = [lost_sign(record), counter(record, residual)]
    if isinstance(loss, Quadratic):
        seen.append(outliers(record, residual))
    return [finding for finding in seen if finding is not None]
