"""Reject requests and records that no estimate can come from."""

from collections.abc import Collection, Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.validation import require
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import Friction

SMALLEST_CURRENT = 1e-9
"""A: below any drive's resolution."""
LARGEST_SIGNAL = 1e6
"""A and rad/s: beyond any wheel, and far from where squares overflow."""
MOTION = 4.0
"""Standard deviations of its noise beyond which a speed is motion."""


def place(records: Sequence[Record]) -> str:
    """The names of records, for a message."""
    return ", ".join(record.name for record in records)


def as_records(records: Record | Sequence[Record]) -> tuple[Record, ...]:
    """One record or several as a tuple.

    Raises:
        InputError: there is none.
    """
    every = (records,) if isinstance(records, Record) else tuple(records)
    if not every:
        raise InputError("records: found none, expected at least one")
    return every


def check_sigma(speed_sigma: float | None) -> None:
    """Refuse a standard deviation of the speed, rad/s, that is not positive.

    Raises:
        InputError: as said.
    """
    if speed_sigma is not None:
        require("speed sigma", speed_sigma, "rad/s", positive=True)


def _fault(records: Sequence[Record], text: str) -> InputError:
    return InputError(f"{place(records)}: {text}")


def check_signals(records: Sequence[Record]) -> None:
    """Refuse records without speeds, or with numbers that no wheel shows.

    Raises:
        InputError: a record has fewer than two speeds, or a current or speed is absurdly large.
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
    """Refuse records that cannot show the parameters asked for.

    Args:
        records: fitted together.
        model: friction model.
        free: names of the estimated parameters.
        noise: standard deviation of the measured speed of each record, rad/s.

    Raises:
        InputError: too few samples, a current that is always zero or, with torques of friction
            estimated as well, always the same in the sense of rotation, or a wheel that never
            moves.
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
                "varies: a constant one cannot tell the motor constant from Coulomb friction",
            )
