"""Checks of an identification of a drive: when it is not valid, and what it should say."""

from gyrostat.identification.drive.control_law import ControlLaw
from gyrostat.identification.result.inverse_dynamics import InverseDynamics

STRONG = 10.0
"""F statistic above which instruments are strong (Staiger and Stock 1997)."""
FOLLOWED = 0.8
"""Smallest share of the variance of the speed that a prediction must have."""
EXPLAINED = 0.5
"""Largest torque error of a valid result, relative to the rms torque."""


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


def warnings_of(inverse: InverseDynamics) -> list[str]:
    """Differences between the methods that are significant."""
    best = inverse.methods["instruments"]
    warnings = []
    for name, value in best.values.items():
        sigma = best.sigma[name]
        least = inverse.methods["least_squares"].values[name]
        if abs(least - value) > 3.0 * sigma and name != "current_bias":
            warnings.append(
                f"{name}: least squares gives {least:.4g}, {(least - value) / sigma:+.1f} sigma "
                "from the result: disturbances in the loop or noise of the speed bias it"
            )
    return warnings
