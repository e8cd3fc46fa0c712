"""Validation of requests and records before an identification."""

from collections.abc import Collection, Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.validation import require
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

SMALLEST_CURRENT = 1e-9
"""Current below the resolution of any drive, A."""
LARGEST_SIGNAL = 1e6
"""Largest current, A, and speed, rad/s: above those of any wheel, and safe to square."""
MOTION = 4.0
"""Standard deviations of the noise above which a speed counts as motion."""


def place(records: Sequence[Record]) -> str:
    """Names of records, for a message."""
    return ", ".join(record.name for record in records)


def as_records(records: Record | Sequence[Record]) -> tuple[Record, ...]:
    """Convert one record or several to a tuple.

    Raises:
        InputError: There is no record.
    """
    every = (records,) if isinstance(records, Record) else tuple(records)
    if not every:
        raise InputError("records: found none, expected at least one")
    return every


def check_sigma(speed_sigma: float | None) -> None:
    """Check that a standard deviation of the speed, rad/s, is positive.

    Raises:
        InputError: The value is not positive.
    """
    if speed_sigma is not None:
        require("speed sigma", speed_sigma, "rad/s", positive=True)


def _fault(records: Sequence[Record], text: str) -> InputError:
    return InputError(f"{place(records)}: {text}")


def check_signals(records: Sequence[Record]) -> None:
    """Check that records contain speeds and only possible numbers.

    Raises:
        InputError: A record has fewer than two speeds, or a current or speed is far too large.
    """
    for record in records:
        count = int(record.valid.sum())
        if count < 2:
            text = f"column speed: found {count} samples that are not missing, expected 2 or more"
            raise _fault([record], text)
        for column, unit in (("current", "A"), ("speed", "rad/s")):
            peak = float(np.nanmax(np.abs(getattr(record, column))))
            if peak > LARGEST_SIGNAL:
                text = f"found {peak:.3g} {unit}, expected less than {LARGEST_SIGNAL:g} {unit}"
                raise _fault([record], f"column {column}: {text}")


def check_excitation(
    records: Sequence[Record], model: type[Friction], free: Collection[str], noise: Sequence[float]
) -> None:
    """Check that records can determine the requested parameters.

    Args:
        records: Records fitted together.
        model: Friction model.
        free: Names of the estimated parameters.
        noise: Standard deviation of the measured speed of each record, rad/s.

    Raises:
        InputError: There are too few samples; the wheel never moves; the current is always zero; or
            friction torques are also estimated and the current is constant relative to the sense
            of rotation.
    """
    samples = sum(int(r.valid.sum()) for r in records)
    if samples <= len(free):
        text = (
            f"found {samples} samples with a speed, expected more than the {len(free)} parameters"
        )
        raise _fault(records, text)
    turning = [
        r.valid & (np.abs(np.nan_to_num(r.speed)) > MOTION * level)
        for r, level in zip(records, noise, strict=True)
    ]
    if sum(int(moves.sum()) for moves in turning) < 0.01 * samples:
        speeds = np.concatenate([r.speed[r.valid] for r in records])
        raise _fault(
            records,
            "column speed: found a wheel that never moves, expected it to turn "
            f"(largest speed {np.max(np.abs(speeds)):.3g} rad/s, noise about {max(noise):.3g} "
            "rad/s)",
        )
    if "motor_constant" in free:
        peak = max(float(np.max(np.abs(r.current))) for r in records)
        if peak < SMALLEST_CURRENT:
            text = f"found at most {peak:.3g} A, expected more than {SMALLEST_CURRENT:g} A"
            raise _fault(records, f"column current: {text}")
        moving = [r.current[m] * np.sign(r.speed[m]) for r, m in zip(records, turning, strict=True)]
        constant = any(
            len(values) and np.ptp(values) == 0.0
            for values in (np.concatenate([r.current for r in records]), np.concatenate(moving))
        )
        torques = {name for name, dimension in model.dimensions().items() if dimension == "torque"}
        if constant and (torques - set(model.vanishing_at)) & set(free):
            raise _fault(
                records,
                "column current: found the same value in every row, expected a current that "
                "varies: a constant one does not distinguish motor constant and Coulomb friction",
            )
