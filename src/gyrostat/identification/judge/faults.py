"""Measurement faults visible in the samples: outliers, pulse counters, wrong units."""

from collections.abc import Mapping, Sequence

import numpy as np

from gyrostat.core.types import Vector
from gyrostat.core.units import RPM
from gyrostat.identification.fit.loss import Loss, Quadratic
from gyrostat.identification.read.clipping import clipped_current
from gyrostat.identification.read.findings import Finding, fault_finding
from gyrostat.identification.read.signs import lost_sign
from gyrostat.identification.read.statistics import quantum
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import NORMAL_MAD

OUTLYING = 5.0
"""Deviation from the neighbours, in standard deviations of the noise, above which a sample is an
outlier: one in two million for normal noise."""
NEIGHBOURS = 5
"""Number of samples in the median with which a sample is compared."""
COARSE = 1.0
"""Smallest step of a quantised speed that is reported, relative to the scatter of residuals."""
WHOLE = 0.02
"""Largest relative deviation of a counter's pulses per revolution from an integer."""

FASTEST, SLOWEST = 1500.0, 0.1
"""Speed above that of any ball-bearing reaction wheel, 14 000 rpm, and largest speed of a record
below which no tachometer shows a motion, 1 rpm, in rad/s."""
LARGEST_CURRENT, SMALLEST_CURRENT = 50.0, 1e-3
"""Currents above that of any reaction wheel drive and below that which turns any wheel, A."""
BACK_EMF = 60.0
"""Largest back-EMF, V: wheel motors run on 5 to 50 V and must overcome their own back-EMF."""
MOTOR_CONSTANTS = (5e-4, 0.14)
"""Motor constants, N·m/A: from the smallest CubeSat wheels to motors whose back-EMF reaches 28 V
at 2000 rpm."""
WEAKEST = 0.005
"""A quarter of the usual motor constant for a flywheel of 1e-3 kg·m², N·m/A."""
GROWTH = 0.4
"""Exponent of the usual motor constant as a power of the flywheel's inertia."""

SPEED_FACTORS = {
    "rpm read as rad/s": RPM,
    "rad/s read as rpm": 1.0 / RPM,
    "rev/s read as rad/s": 2.0 * np.pi,
    "rad/s read as rev/s": 0.5 / np.pi,
    "deg/s read as rad/s": np.pi / 180.0,
    "rad/s read as deg/s": 180.0 / np.pi,
    "mrad/s read as rad/s": 1e-3,
    "krpm read as rpm": 1e3,
}
"""Wrong unit -> true divided by recorded speed."""
CURRENT_FACTORS = {"mA read as A": 1e-3, "A read as mA": 1e3}
"""Wrong unit -> true divided by recorded current."""
TIME_FACTORS = {"ms read as s": 1e-3, "s read as ms": 1e3}
"""Wrong unit -> true divided by recorded time."""


def outliers(record: Record, residual: Vector) -> Finding | None:
    """Find single speeds far from their neighbours.

    Args:
        record: Record of the samples.
        residual: Measured minus modelled speed, (N,), rad/s; NaN where missing.
    """
    samples = residual[record.valid]
    if len(samples) < 4 * NEIGHBOURS:
        return None
    padded = np.pad(samples, NEIGHBOURS // 2, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, NEIGHBOURS)
    around = np.median(np.delete(windows, NEIGHBOURS // 2, axis=1), axis=1)
    apart = samples - around
    # includes the noise of the neighbours' median
    level = NORMAL_MAD * float(np.median(np.abs(apart)))
    step = quantum(record.speed[record.valid]) or 0.0
    z = np.abs(apart) / max(level, step, np.finfo(float).tiny)
    far = z > OUTLYING
    if level == 0.0 or not far.any():
        return None
    count = int(far.sum())
    evidence = float(np.sum(z[far] ** 2 - 2.0 * np.log(len(samples))))
    title = f"outliers in the speed of {record.name}, fraction of the samples"
    return fault_finding(
        "outliers", title, count / len(samples), evidence, significance=float(z.max())
    )


def counter(record: Record, residual: Vector) -> Finding | None:
    """Find a coarse quantisation of the speed, as caused by a pulse counter.

    Args:
        record: Record of the samples.
        residual: Measured minus modelled speed, (N,), rad/s; NaN where missing.
    """
    speeds = record.speed[record.valid]
    step = quantum(speeds)
    scatter = float(np.std(residual[record.valid]))
    if step is None or step < COARSE * scatter:
        return None
    gate = float(np.median(np.diff(record.time)))
    pulses = 2.0 * np.pi / (step * gate)
    integer = round(pulses)
    title = f"quantised speed of {record.name} (step {step / RPM:.4g} rpm)"
    if integer >= 1 and abs(pulses - integer) < WHOLE * integer:
        title += f": a pulse counter with {integer} pulses per turn and a gate of {gate:.3g} s"
    return fault_finding("quantum", title, step, float(len(speeds)), unit="rad/s")


def implausible(
    motor_constant: float | None, inertia: float | None, speed: float, current: float
) -> list[str]:
    """Reasons why no reaction wheel has these values; empty if one may have them.

    Args:
        motor_constant: Estimated motor constant, N·m/A; None if it was not estimated.
        inertia: Inertia, kg·m²; None if unknown.
        speed: Largest speed, rad/s.
        current: Largest current, A.
    """
    motor = abs(motor_constant or 0.0)
    reasons = []
    if speed > FASTEST:
        reasons.append(f"the wheel reaches {speed:.0f} rad/s = {speed / RPM:.0f} rpm")
    elif 0.0 < speed < SLOWEST:
        reasons.append(f"the wheel reaches only {speed:.3g} rad/s = {speed / RPM:.3g} rpm")
    if motor * speed > BACK_EMF:
        reasons.append(
            f"k_m times the largest speed is a back-EMF of {motor * speed:.0f} V, above any "
            "wheel's supply"
        )
    if current > LARGEST_CURRENT:
        reasons.append(f"the current reaches {current:.0f} A")
    elif 0.0 < current < SMALLEST_CURRENT:
        reasons.append(f"the current reaches only {current:.3g} A")
    low, high = MOTOR_CONSTANTS
    if motor_constant is not None:
        if inertia is not None:
            low = max(low, WEAKEST * (inertia / 1e-3) ** GROWTH)
        if not low <= motor <= high:
            reasons.append(f"k_m = {motor:.3g} N·m/A lies outside {low:.2g} to {high:g}")
    return reasons


def wrong_units(
    parameters: Mapping[str, float], estimated: Sequence[str], records: Sequence[Record]
) -> Finding | None:
    """Find wrong units whose correction would make an implausible wheel plausible.

    Args:
        parameters: Name -> value of estimated and held parameters, SI.
        estimated: Names of the estimated parameters.
        records: Records of the fit.
    """
    speed = max(float(np.nanmax(np.abs(r.speed))) for r in records)
    current = max(float(np.max(np.abs(r.current))) for r in records)
    motor = parameters.get("motor_constant") if "motor_constant" in estimated else None
    inertia = None if "inertia" in estimated else parameters.get("inertia")
    why = implausible(motor, inertia, speed, current)
    if not why:
        return None

    def cures(of_speed: float = 1.0, of_current: float = 1.0, of_time: float = 1.0) -> bool:
        motor_constant = None if motor is None else motor * of_speed / (of_current * of_time)
        return not implausible(motor_constant, inertia, of_speed * speed, of_current * current)

    slips = [slip for slip, factor in SPEED_FACTORS.items() if cures(of_speed=factor)]
    slips += [slip for slip, factor in CURRENT_FACTORS.items() if cures(of_current=factor)]
    slips += [slip for slip, factor in TIME_FACTORS.items() if cures(of_time=factor)]
    cause = f"most likely {' or '.join(slips)}" if slips else "no single wrong unit explains it"
    title = f"implausible units: {'; '.join(why)}; {cause}"
    return fault_finding("units", title)


def opposed_signs(motor_constant: float, sigma: float) -> Finding | None:
    """Finding for a negative motor constant: current or speed has the wrong sign.

    Args:
        motor_constant: Motor constant, N·m/A.
        sigma: Standard deviation of the motor constant, N·m/A.
    """
    if motor_constant >= -2.0 * sigma:
        return None
    return fault_finding("opposed_signs", "current and speed of opposite senses")


def found_in(record: Record, residual: Vector, loss: Loss) -> list[Finding]:
    """Measurement faults visible in the samples of one record.

    Args:
        record: Record of the samples.
        residual: Measured minus modelled speed, (N,), rad/s; NaN where missing.
        loss: Loss of the fit; with a robust one, outliers are not reported.
    """
    findings = [lost_sign(record), clipped_current(record), counter(record, residual)]
    if isinstance(loss, Quadratic):
        findings.append(outliers(record, residual))
    return [finding for finding in findings if finding is not None]
