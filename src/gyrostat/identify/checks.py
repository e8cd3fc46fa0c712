"""Records that no estimate can come from, refused with the reason."""

from collections.abc import Collection, Sequence

import numpy as np

from gyrostat.errors import InputError
from gyrostat.telemetry import Record

SMALLEST_CURRENT = 1e-9
"""A: below any drive's resolution."""
LARGEST_SIGNAL = 1e6
"""A and rad/s: beyond any wheel, and far from where squares overflow."""


def _fault(records: Sequence[Record], text: str) -> InputError:
    return InputError(f"{', '.join(r.name for r in records)}: {text}")


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


def check_excitation(records: Sequence[Record], free: Collection[str], noise: float) -> None:
    """Refuse records that cannot show the parameters asked for.

    Args:
        records: fitted together.
        free: names of the estimated parameters.
        noise: standard deviation of the measured speed, rad/s.

    Raises:
        InputError: too few samples, a current that never changes or is always zero, or a wheel
            that never moves.
    """
    samples = sum(int(r.valid.sum()) for r in records)
    if samples <= len(free):
        text = (
            f"found {samples} samples with a speed, expected more than the {len(free)} parameters"
        )
        raise _fault(records, text)
    if "motor_constant" in free:
        if all(np.ptp(r.current) == 0.0 for r in records):
            raise _fault(
                records,
                "column current: found the same value in every row, expected a current that "
                "varies: a constant one cannot tell the motor constant from Coulomb friction",
            )
        peak = max(float(np.max(np.abs(r.current))) for r in records)
        if peak < SMALLEST_CURRENT:
            text = f"found at most {peak:.3g} A, expected more than {SMALLEST_CURRENT:g} A"
            raise _fault(records, f"column current: {text}")
    speeds = np.concatenate([r.speed[r.valid] for r in records])
    if np.mean(np.abs(speeds) > 4.0 * noise) < 0.01:
        raise _fault(
            records,
            "column speed: found a wheel that never moves, expected it to turn "
            f"(largest speed {np.max(np.abs(speeds)):.3g} rad/s, noise about {noise:.3g} rad/s)",
        )
