"""Detect and restore missing or opposed signs of current and speed, by the equation of motion.

Over windows of a record the change of the speed is a linear function of the integrals of current,
speed and sense of rotation. If the fit is clearly better with a sign restored, the record holds
only the magnitude.
"""

from dataclasses import replace

import numpy as np

from gyrostat.core.types import Matrix, Vector
from gyrostat.identification.read.findings import Finding, fault_finding
from gyrostat.identification.read.statistics import noise_level
from gyrostat.telemetry import Record
from gyrostat.telemetry.signals import held_integral, runs

WINDOWS = 150
"""Number of windows of a record."""
FEWEST_WINDOWS = 12
"""Smallest number of windows for a decision."""
CLEARLY_BETTER = 0.5
"""Ratio of the misfits with the sign restored and as recorded, below which it is restored."""
TOUCHES = 0.03
"""Fraction of the largest speed, or `CLEAR` times the noise, below which a speed touches zero."""
CLEAR = 4.0
"""Standard deviations of the noise above which a speed has a definite sign."""
SMOOTHED = 5
"""Number of samples of the running mean that gives the sense of rotation."""
MISSING = 0.5
"""Fraction of valid speeds around a sample, below which an unseen zero speed is possible."""
ROUNDS = 5
"""Number of iterations that refine the sign of a current."""
BOTH_WAYS = 0.05
"""Smallest fraction of samples with the rarer sign in a signal of both signs."""


def _smooth(values: Vector) -> Vector:
    """Running mean; at both ends over the samples that there are."""
    kernel = np.ones(min(SMOOTHED, len(values)))
    count = np.convolve(np.ones(len(values)), kernel, mode="same")
    return np.convolve(values, kernel, mode="same") / count


def filled_speed(record: Record) -> Vector:
    """Speed with missing samples interpolated linearly, (N,)."""
    return np.interp(record.time, record.time[record.valid], record.speed[record.valid])


def motion_regression(
    time: Vector, current: Vector, speed: Vector, further: Matrix | None = None
) -> tuple[Vector, float]:
    """Regress the change of the speed over windows on current, speed and sense of rotation.

    Args:
        time: Time, (N,), s.
        current: Current, (N,), A.
        speed: Speed without missing samples, (N,), rad/s.
        further: Further currents, (N, k), A, each with a coefficient of its own.

    Returns:
        k_m/J, b/J, c/J and the k further coefficients, and the residual sum of squares.
    """
    edges = np.unique(np.linspace(0, len(time) - 1, WINDOWS + 1).astype(int))
    smooth = _smooth(speed)

    def change(rates: Vector) -> Vector:
        return np.diff(held_integral(rates, time)[edges])

    rows = np.column_stack(
        [
            change(current),
            -change(smooth),
            -change(np.sign(smooth)),
            *(change(column) for column in ([] if further is None else further.T)),
        ]
    )
    right = np.diff(smooth[edges])
    size = np.linalg.norm(rows, axis=0)
    size = np.where(size > 0.0, size, 1.0)
    coefficients = np.linalg.lstsq(rows / size, right, rcond=1e-10)[0] / size
    return coefficients, float(np.sum((right - rows @ coefficients) ** 2))


def _both_ways(values: Vector, clear: float) -> bool:
    return bool(min(np.mean(values > clear), np.mean(values < -clear)) > BOTH_WAYS)


def signed_speed(record: Record) -> Record | None:
    """Restore the sign of a speed that was recorded as a magnitude.

    Between two zero speeds the sense of rotation is constant: the one for which current and change
    of speed agree.

    Args:
        record: Record with a speed that is never clearly negative.

    Returns:
        A copy with the sign restored; None if the speed never touches zero.
    """
    size: Vector = np.abs(filled_speed(record))
    level = max(TOUCHES * float(size.max()), CLEAR * noise_level(size))
    # long runs of missing speeds may include zero: tachometers fail at low speed
    low = (_smooth(size) < level) | (_smooth(record.valid.astype(np.float64)) < MISSING)
    if not low.any() or low.all():
        return None
    # a zero is assumed at the minimum of each run of low speeds
    cuts = [int(a + np.argmin(size[a:b])) for a, b in runs(low)]
    parts = np.split(np.arange(len(size)), [c for c in cuts if 0 < c < len(size) - 1])
    smooth, sense = _smooth(size), np.ones(len(size))
    for part in parts:
        inside = part[:-1]
        agreement = float(np.sum(record.current[inside] * (smooth[inside + 1] - smooth[inside])))
        sense[part] = 1.0 if agreement >= 0.0 else -1.0
    speed = np.where(record.valid, sense * np.abs(record.speed), np.nan)
    return replace(
        record, speed=speed, notes=(*record.notes, "sign of speed restored from the current")
    )


def signed_current(record: Record) -> Record:
    """Restore the sign of a current that was recorded as a magnitude.

    The sign is that of the setpoint. Without a setpoint it is that of the motor torque in the
    equation of motion: at first from the acceleration, then with the friction estimated from that.

    Args:
        record: Record with a current that is never negative.
    """
    size, source = np.abs(record.current), "setpoint"
    if record.setpoint is not None and np.any(record.setpoint):
        guide = np.where(record.setpoint == 0.0, filled_speed(record), record.setpoint)
    else:
        source = "the torque"
        speed = _smooth(filled_speed(record))
        acceleration = _smooth(np.gradient(speed, record.time))
        guide = acceleration
        for _ in range(ROUNDS):
            trial = np.where(guide < 0.0, -size, size)
            (_, viscous, coulomb), _ = motion_regression(record.time, trial, speed)
            guide = acceleration + max(viscous, 0.0) * speed + max(coulomb, 0.0) * np.sign(speed)
    current = np.where(guide < 0.0, -size, size)
    return replace(
        record, current=current, notes=(*record.notes, f"sign of current taken from {source}")
    )


RESTORE = {"unsigned_speed": signed_speed, "unsigned_current": signed_current}
"""Finding -> function that restores the missing sign of a record."""


def lost_sign(record: Record) -> Finding | None:
    """Test whether current or speed of a record was recorded as a magnitude.

    Args:
        record: Record as measured.

    Returns:
        The finding; None if both have their signs.
    """
    speed = filled_speed(record)
    noise = CLEAR * noise_level(record.speed[record.valid])
    clear = max(noise, TOUCHES * float(np.max(np.abs(speed))))
    # smoothed, because the sign of single noisy samples at rest is random
    turns_both_ways = _both_ways(_smooth(speed), clear)
    pulls_both_ways = _both_ways(record.current, 0.0)
    if turns_both_ways == pulls_both_ways or len(record.time) < FEWEST_WINDOWS:
        return None
    if turns_both_ways:
        if np.any(record.current < 0.0) and np.any(record.current > 0.0):
            return None
        quantity, candidate = "current", signed_current(record)
    else:
        quantity, candidate = "speed", signed_speed(record)
        if candidate is None or np.min(_smooth(speed)) < -clear:
            return None
    _, misfit = motion_regression(record.time, record.current, speed)
    _, better = motion_regression(record.time, candidate.current, filled_speed(candidate))
    if not better < CLEARLY_BETTER * misfit:
        return None
    evidence = WINDOWS * float(np.log(misfit / max(better, np.finfo(float).tiny)))
    title = f"{quantity} without sign in {record.name}"
    return fault_finding(f"unsigned_{quantity}", title, evidence=evidence)
