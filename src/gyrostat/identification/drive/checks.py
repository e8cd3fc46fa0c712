"""Checks of an identification of a drive: when it is not valid, and what it should say."""

from collections.abc import Sequence

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.drive.delay import Delay
from gyrostat.identification.drive.equation import Equation
from gyrostat.identification.drive.tracking import Tracking
from gyrostat.identification.read.checks import place
from gyrostat.identification.result.inverse_dynamics import InverseDynamics
from gyrostat.telemetry import Record

STRONG = 10.0
"""F statistic above which instruments are strong (Staiger and Stock 1997)."""
FOLLOWED = 0.8
"""Smallest share of the variance of the speed that a prediction must have."""
EXPLAINED = 0.5
"""Largest torque error of a valid result, relative to the rms torque."""
DELAYED, MOVED = 3.0, 2.0
"""Smallest delay between current and speed in its standard deviations, and smallest effect on an
estimate in those of the estimate, that are warned of."""
SHORTEST = 0.1
"""Smallest delay in sample intervals that is warned of."""
SLOW = 0.02
"""Share of the largest speed below which its sign may be that of noise."""
GAINS, CERTAIN = 0.1, 3.0
"""Difference of the ratio of tracking errors from 1 that is warned of: at least so much, and so
many of its standard deviations."""
SAME = 0.9
"""Share of the changes of the speed at which a reference is the speed itself."""


def check_reference(record: Record) -> None:
    """Check that the reference is not the measured motion.

    Raises:
        InputError: It is, and has part in the disturbances and in the noise.
    """
    if record.reference is None:
        name, commanded, measured = "setpoint", record.setpoint, record.speed
    elif record.averaged:
        name, measured = "reference", record.speed[1:]
        commanded = np.diff(record.reference) / np.diff(record.time)
    else:
        return
    if commanded is None:
        return
    moves = np.flatnonzero(np.abs(np.diff(measured)) > 0.0) + 1
    same = np.isclose(commanded[moves], measured[moves], rtol=1e-6, atol=1e-9)
    if len(moves) and np.mean(same) > SAME:
        raise InputError(
            f"{record.name}: column {name}: found the measured motion, expected what the drive was "
            "commanded"
        )


def check_senses(records: Sequence[Record], equation: Equation) -> None:
    """Check that a drive turns both ways where friction and an offset would be alike otherwise.

    Raises:
        InputError: It turns one way, and both are to be estimated.
    """
    dry = {"coulomb", "static"} & set(equation.names)
    if not dry or "current_bias" not in equation.names:
        return
    speeds = np.concatenate([record.speed[record.valid] for record in records])
    fast = np.abs(speeds) > SLOW * np.max(np.abs(speeds))
    if len(np.unique(np.sign(speeds[fast]))) == 1:
        raise InputError(
            f"{place(records)}: found a drive that turns one way, expected both: {min(dry)} and an "
            "offset of the current are alike there; --hold current_bias=0 where there is none"
        )


def refused(inverse: InverseDynamics, law: ControlLaw | None) -> list[str]:
    """Reasons why the estimates are not valid."""
    reasons, best = [], inverse.methods["instruments"]
    if inverse.followed < FOLLOWED:
        what = "a linear filter of the reference" if law is None else "the stated control law"
        reasons.append(
            f"{what} has only {100.0 * inverse.followed:.0f} % of the variance of the measured "
            f"speed, expected {100.0 * FOLLOWED:.0f} % or more: it is not the loop of this record"
        )
    if inverse.strength < STRONG:
        values, sigma = best.values, best.sigma
        name = min(set(values) - {"current_bias"}, key=lambda n: abs(values[n]) / sigma[n])
        reasons.append(
            f"the motion that the reference causes does not determine all parameters (F = "
            f"{inverse.strength:.1f}, expected {STRONG:g} or more): hold {name} at a known value"
        )
    error = best.torque_error
    if error > EXPLAINED:
        reasons.append(
            f"{100.0 * error:.0f} % of the rms torque are not explained: the current at the "
            "samples is not that between them, or the model is not that of this drive"
        )
    return reasons


def warnings_of(inverse: InverseDynamics, shift: Delay, tracking: Tracking | None) -> list[str]:
    """Signs of a bias: delay, a control law or held-out record of another drive, other methods."""
    best = inverse.methods["instruments"]
    warnings = _of_delay(inverse, shift)
    for what, errors in (
        ("the simulated drive: the control law", inverse.simulated),
        ("the fit: the drive, a sign or a unit", inverse.held_out),
    ):
        for record, error in errors.items():
            if error > max(EXPLAINED, 2.0 * best.torque_error):
                warnings.append(
                    f"{record}: {100.0 * error:.0f} % of the rms torque are not explained by "
                    f"{what} is not that of this record"
                )
    for name, value in best.values.items():
        sigma = best.sigma[name]
        least = inverse.methods["least_squares"].values[name]
        if abs(least - value) > 3.0 * sigma and name != "current_bias":
            warnings.append(
                f"{name}: least squares gives {least:.4g}, {(least - value) / sigma:+.1f} sigma "
                "from the result: disturbances in the loop or noise of the speed bias it"
            )
    return warnings + _of_law(tracking)


def _of_law(tracking: Tracking | None) -> list[str]:
    if tracking is None:
        return []
    ratio, sigma = tracking
    if abs(ratio - 1.0) < max(GAINS, CERTAIN * sigma):
        return []
    return [
        f"the tracking error is {ratio:.3g} ± {sigma:.2g} times that of the stated control law: "
        "its gains, their units, or the rate and delay of the loop are not those of this record, "
        "at whose samples the law is simulated (instruments need no exact law, output error does)"
    ]


def _of_delay(inverse: InverseDynamics, shift: Delay) -> list[str]:
    best = inverse.methods["instruments"]
    moved = {
        name: (value - best.values[name]) / best.sigma[name]
        for name, value in zip(best.values, shift.values.tolist(), strict=True)
        if name != "current_bias"
    }
    worst = max(moved, key=lambda name: abs(moved[name]))
    least = max(DELAYED * shift.sigma, SHORTEST * shift.interval)
    if abs(shift.time) < least or abs(moved[worst]) < MOVED:
        return []
    late = "current" if shift.time > 0.0 else "speed"
    return [
        f"the recorded {late} is late by {1e3 * abs(shift.time):.3g} ± {1e3 * shift.sigma:.2g} ms: "
        f"without the delay, {worst} moves by {moved[worst]:+.1f} sigma; correct the times, or "
        "--current-hold"
    ]
