"""Warnings about a fit from statistics and from the physics of wheels."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gyrostat.core.units import RPM
from gyrostat.identification.fit import Fit
from gyrostat.telemetry import Record

BACK_EMF = 60.0
"""V: motors of reaction wheels run on 5 to 50 V, and must overcome their own back-EMF."""
FASTEST = 1500.0
"""rad/s: 14 000 rpm, beyond any ball-bearing reaction wheel."""
LARGEST_CURRENT = 50.0
"""A: beyond any reaction wheel drive."""
MOTOR_CONSTANTS = (5e-4, 0.14)
"""N·m/A: from the smallest cubesat wheels to motors that a 28 V bus stops at 2000 rpm."""


STATED = (0.8, 1.25)
"""Scatter over the stated noise between which the two agree."""
UNEXPLAINED = 1.5
"""Scatter over the noise that a record itself shows from which something is wrong."""


PROBABLE = 0.8
"""Posterior probability from which an effect is named as a cause."""


@dataclass(frozen=True)
class Scatter:
    """How far the speeds of a record lie from what was fitted to them.

    Attributes:
        name: of the record.
        level: standard deviation of the distance, rad/s, outliers apart that a loss forgives.
        stated: noise that the user stated, rad/s, or None.
        noise: that the speeds alone show, rad/s; None where the method does not tell.
    """

    name: str
    level: float
    stated: float | None
    noise: float | None = None


def _unit_warnings(fit: Fit) -> list[str]:
    """Signs that a column does not have the unit that its header says."""
    # not every dedicated method knows the motor
    motor = fit.parameters.get("motor_constant", 0.0)
    speed = max(float(np.nanmax(np.abs(r.speed))) for r in fit.records)
    current = max(float(np.max(np.abs(r.current))) for r in fit.records)
    found = []
    if speed > FASTEST:
        found.append(f"the wheel reaches {speed:.0f} rad/s = {speed / RPM:.0f} rpm")
    if abs(motor) * speed > BACK_EMF:
        found.append(
            f"k_m times the largest speed is a back-EMF of {abs(motor) * speed:.0f} V, above any "
            "wheel's supply"
        )
    if current > LARGEST_CURRENT:
        found.append(f"the current reaches {current:.0f} A")
    low, high = MOTOR_CONSTANTS
    if "motor_constant" in fit.names and not low <= abs(motor) <= high:
        found.append(f"k_m = {motor:.3g} N·m/A lies outside {low:g} to {high:g}")
    if not found:
        return []
    return [
        f"check the units of the record: {'; '.join(found)} (rpm taken as rad/s, deg/s as rad/s or "
        "mA as A would do this)"
    ]


def impossible(fit: Fit) -> list[str]:
    """Estimates that no wheel has, beyond what their sigma allows.

    Args:
        fit: the result.
    """
    found = []
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        wheel = fit.dimensions[name] in ("motor_constant", "torque", "viscous")
        if wheel and value < -2.0 * sigma:
            found.append(f"{name} is negative ({value:.3g}): no wheel has this")
    if fit.parameters.get("motor_constant", 0.0) < 0.0:
        found.append("current and speed have opposite senses: turn the sign of one of them")
    for name, seen in fit.observability.items():
        if seen.observable and seen.significance < 0.0:
            reference = fit.model.vanishing_at[name]
            found.append(
                f"{name} lies {-seen.significance:.1f} sigma below {reference}: the model "
                "contradicts the record (no friction rises as a wheel starts to turn)"
            )
    return found


def _record_warnings(records: Sequence[Record]) -> list[str]:
    found = []
    for record in records:
        steps = np.diff(record.time)
        usual = float(np.median(steps))
        gaps = int(np.sum(steps > 10.0 * usual))
        if gaps:
            found.append(
                f"{record.name}: {gaps} gaps longer than ten usual sample times "
                f"({usual:.3g} s); the current is taken as held through them"
            )
    return found


def _scatter_warnings(scatter: Sequence[Scatter]) -> list[str]:
    found = []
    for record in scatter:
        if record.stated is not None:
            low, high = STATED
            if not low < record.level / record.stated < high:
                found.append(
                    f"{record.name}: the residuals are {record.level:.3g} rad/s where the stated "
                    f"speed sigma is {record.stated:.3g} rad/s: one of the two is wrong"
                )
        elif record.noise and record.level > UNEXPLAINED * record.noise:
            found.append(
                f"{record.name}: the residuals are {record.level:.3g} rad/s, "
                f"{record.level / record.noise:.1f} times the noise that the record itself shows: "
                "the model misses something, or no start led to the right minimum"
            )
    return found


def _correlation_warning(fit: Fit) -> str:
    """What correlated residuals mean, and what most probably causes them."""
    assert fit.whiteness is not None
    worst = fit.whiteness.worst_block
    scale = f", most clearly in means of {worst[0]} samples" if worst else ""
    text = (
        f"the residuals of the least-squares fit are correlated in time{scale}: the model misses "
        "something"
    )
    if not fit.effects:
        return f"{text}; sigma allows for correlated residuals"
    found = [e for e in fit.effects if e.probability > PROBABLE]
    named = ", ".join(f"{e.title} ({100.0 * e.probability:.0f} %)" for e in found)
    cause = f"probably {named}" if named else "no candidate effect explains it"
    return f"{text}; {cause}; values and sigma allow for all candidates"


def fit_warnings(fit: Fit, reason: str, scatter: Sequence[Scatter]) -> list[str]:
    """List what a reader should know, most serious first.

    Args:
        fit: the result.
        reason: why the iteration did not converge; empty where it did.
        scatter: of the records about the fit.
    """
    warnings = []
    if reason:
        text = f"did not converge in {fit.iterations} iterations ({reason})"
        warnings.append(f"{text}: not a valid result")
    warnings += _unit_warnings(fit) + impossible(fit) + _record_warnings(fit.records)
    if "current_bias" in fit.names:
        bias = fit.parameters["current_bias"]
        warnings.append(
            f"current_bias = {bias:.3g} A belongs to the bench and is not in model.toml: to "
            f"validate with the same drive, hold it there (validate --hold current_bias={bias:.6g})"
        )
    warnings += [o.advice for o in fit.observability.values() if o.advice]
    if fit.whiteness is not None and not fit.whiteness.white:
        warnings.append(_correlation_warning(fit))
    return warnings + _scatter_warnings(scatter)
