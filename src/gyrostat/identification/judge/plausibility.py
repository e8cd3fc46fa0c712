"""Warnings about a fit, from statistics and from the physics of wheels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gyrostat.identification.judge.faults import opposed_signs, wrong_units
from gyrostat.identification.read.findings import Finding, by_evidence
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.uncertainty.effects import RESOLVED
from gyrostat.wheel.friction.contract import curve_fault, is_free_at_rest

STATED = (0.8, 1.25)
"""Range of the ratio of scatter to stated noise in which the two agree."""
UNEXPLAINED = 1.5
"""Ratio of scatter to the noise estimated from the record, above which a warning is given."""
UNRELIABLE = 0.25
"""Random-walk torque, fraction of the dry friction, above which it hides the friction."""
CERTAIN = 1e-6
"""Probability below which the ripple is known to be absent, or present."""
MOVED, MOST_MOVED = 0.5, 3
"""Smallest change of an estimate that is reported, in standard deviations by noise, and how many
are reported."""


@dataclass(frozen=True)
class Scatter:
    """Scatter of the speeds of a record about the fit.

    Attributes:
        name: Name of the record.
        level: Standard deviation of the residuals, rad/s, without outliers that a robust loss
            discounts.
        stated: Noise stated by the user, rad/s, or None.
        noise: Noise estimated from the speeds alone, rad/s; None if the method gives none.
    """

    name: str
    level: float
    stated: float | None
    noise: float | None = None


def impossible(fit: Fit) -> list[str]:
    """Messages about estimates that are not valid whatever their uncertainty.

    No wheel can have them, or the model does not explain the record, so that its linearisation,
    from which the uncertainty follows, does not hold.

    Args:
        fit: Result of the identification.
    """
    messages = _unknown_torque(fit)
    for name, value, sigma in zip(fit.names, fit.values, fit.sigma, strict=True):
        wheel = name == "motor_constant" or name in fit.model.coefficients()
        if wheel and name not in fit.model.signed() and value < -2.0 * sigma:
            messages.append(f"{name} is negative ({value:.3g}): no wheel has this")
    if fit.parameters.get("motor_constant", 0.0) < 0.0:
        messages.append("current and speed have opposite senses: reverse the sign of one of them")
    for name, observability in fit.observability.items():
        if observability.observable and observability.significance < 0.0:
            reference = fit.model.vanishing_at[name]
            messages.append(
                f"{name} lies {-observability.significance:.1f} sigma below {reference}: the model "
                "contradicts the record (no friction rises as a wheel starts to turn)"
            )
    return messages + _no_friction(fit)


def _no_friction(fit: Fit) -> list[str]:
    """Message about a law of the user's whose estimated curve is no friction."""
    law = fit.model
    if law.is_shipped() or not set(law.dimensions()) <= set(fit.parameters):
        return []
    fault = curve_fault(law, law.possible(fit.parameters))
    return [f"{law.__name__} at the estimates: {fault}"] if fault else []


def _free_at_rest(fit: Fit) -> list[str]:
    """Message about a law of the user's that never lets the wheel stick."""
    law, values = fit.model, fit.parameters
    if law.is_shipped() or not set(law.dimensions()) <= set(values):
        return []
    if not is_free_at_rest(law.of(**{name: values[name] for name in law.dimensions()})):
        return []
    return [f"{law.__name__} has no friction at rest: the modelled wheel never sticks"]


def _scatter_warnings(scatter: Sequence[Scatter]) -> list[str]:
    warnings = []
    for record in scatter:
        if record.stated is not None:
            low, high = STATED
            if not low < record.level / record.stated < high:
                warnings.append(
                    f"{record.name}: the residuals are {record.level:.3g} rad/s, but the stated "
                    f"speed sigma is {record.stated:.3g} rad/s: one of the two is wrong"
                )
        elif record.noise and record.level > UNEXPLAINED * record.noise:
            warnings.append(
                f"{record.name}: the residuals are {record.level:.3g} rad/s, "
                f"{record.level / record.noise:.1f} times the noise that the record itself shows: "
                "the model is incomplete, or no start led to the right minimum"
            )
    return warnings


def _sentence(fit: Fit, finding: Finding) -> str:
    """Message of a finding: effect, changes of the parameters, and option that includes it."""
    size = ""
    if finding.sigma is not None:
        factor, unit = (100.0, " %") if finding.unit == "1" else (1.0, f" {finding.unit}")
        size = f" of {factor * finding.value:.3g} ± {factor * finding.sigma:.2g}{unit}"
    elif finding.significance is not None:
        size = f" ({finding.value:.3g})" if finding.unit == "1" else ""
    parts = [f"the record shows {finding.titles[0]}{size}"]
    if len(finding.titles) > 1:
        parts[0] += f", or {' or '.join(finding.titles[1:])}: it does not distinguish them"
    if finding.evidence is not None:
        parts.append(f"BIC falls by {finding.evidence:.0f}")
    noise = dict(zip(fit.names, fit.noise_sigma.tolist(), strict=True))
    shifts = {n: s / noise[n] for n, s in finding.shifts.items() if noise.get(n)}
    largest = sorted(shifts, key=lambda n: -abs(shifts[n]))[:MOST_MOVED]
    words = [f"{n} by {shifts[n]:+.1f} sigma" for n in largest if abs(shifts[n]) > MOVED]
    if words:
        parts.append(f"including it changes {', '.join(words)} of least squares")
    parts.append(" or ".join(finding.options))
    return "; ".join(parts)


def _correlation_warning(fit: Fit) -> str:
    """Warning about correlated residuals."""
    assert fit.whiteness is not None
    worst = fit.whiteness.worst_block
    scale = f", most clearly in means of {worst[0]} samples" if worst else ""
    text = (
        f"the residuals of the least-squares fit are correlated in time{scale}: the model is "
        "incomplete"
    )
    if not fit.effects:
        return f"{text}; sigma allows for correlated residuals"
    cause = "see the diagnosis" if fit.findings else "no candidate effect explains it"
    return f"{text}; {cause}"


def _unknown_torque(fit: Fit) -> list[str]:
    """Message about an unknown torque that hides the friction."""
    walk = next((e for e in fit.effects if e.name == "torque_walk"), None)
    if walk is None or walk.probability < 0.5 or walk.value < UNRELIABLE:
        return []
    return [
        f"an unknown torque of {100.0 * walk.value:.0f} % of the dry friction remains: values and "
        "sigma are not reliable; the current at the samples does not explain the motion (does it "
        "change between them, or is it clipped?); --method steady uses held speeds alone, and "
        "--method inverse is for a drive in closed loop"
    ]


def _ripple(fit: Fit) -> list[str]:
    """Advice to state a torque ripple where sigma depends on one that the record hardly tells."""
    sigma = dict(zip(fit.names, fit.noise_sigma.tolist(), strict=True))
    fine = [
        n for n in fit.model.vanishing_at if sigma.get(n, np.inf) < RESOLVED * fit.parameters[n]
    ]
    chance = next((e.probability for e in fit.effects if e.name == "crossing_ripple"), 0.0)
    if not fine or not CERTAIN < chance < 1.0 - CERTAIN:
        return []
    return [
        f"{', '.join(fine)}: sigma allows for a torque ripple, which the few breakaways of the "
        "records hardly tell: --ripple states it (rms over the dry friction; 0: none)"
    ]


def _feedback(fit: Fit) -> list[str]:
    """Warning about a record in closed loop, which least squares does not allow for."""
    if fit.feedback is None or not fit.feedback.found:
        return []
    probability = fit.feedback.probability
    cause = (
        "the record is of a closed loop, as stated"
        if probability is None
        else "the record is of a closed loop: the current answers earlier residuals of the speed "
        f"(p = {probability:.1g}; --loop open, if it is not)"
    )
    return [
        f"{cause}; disturbances and noise of the speed then drive the current, which biases "
        "the parameters; --method inverse, with the column setpoint or reference, is not biased"
    ]


def fit_warnings(fit: Fit, reason: str, scatter: Sequence[Scatter]) -> list[str]:
    """List the warnings about a fit, most serious first.

    Args:
        fit: Result of the identification.
        reason: Reason why the iteration did not converge; empty if it did.
        scatter: Scatter of each record about the fit.
    """
    warnings = []
    if reason:
        text = f"did not converge in {fit.iterations} iterations ({reason})"
        warnings.append(f"{text}: not a valid result")
    warnings += [_sentence(fit, finding) for finding in fit.findings]
    warnings += impossible(fit)
    warnings += _free_at_rest(fit)
    warnings += _feedback(fit)
    warnings += _ripple(fit)
    if "current_bias" in fit.names:
        bias = fit.parameters["current_bias"]
        warnings.append(
            f"current_bias = {bias:.3g} A belongs to the bench and is not in model.toml: to "
            f"validate with the same drive, hold it there (validate --hold current_bias={bias:.6g})"
        )
    warnings += [o.advice for o in fit.observability.values() if o.advice]
    # differences of an angle have alternating errors
    differences = all(r.averaged for r in fit.records)
    if fit.whiteness is not None and not fit.whiteness.white and not differences:
        warnings.append(_correlation_warning(fit))
    return warnings + _scatter_warnings(scatter)


def judged(
    fit: Fit,
    reason: str,
    scatter: Sequence[Scatter],
    *,
    faults: Sequence[Finding] = (),
    warnings: Sequence[str] = (),
    refused: Sequence[str] = (),
) -> Fit:
    """Fit with its diagnosis, warnings and impossible values added.

    Args:
        fit: Result of the identification, with the findings of the residuals.
        reason: Reason why the iteration did not converge; empty if it did.
        scatter: Scatter of each record about the fit.
        faults: Measurement faults found in the samples.
        warnings: Further warnings.
        refused: Further reasons why the estimates are not valid.
    """
    # some bench methods have no motor constant
    motor = fit.parameters.get("motor_constant", 0.0)
    estimated = "motor_constant" in fit.names
    sigma = fit.sigma[fit.names.index("motor_constant")] if estimated else 0.0
    physical = (
        wrong_units(fit.parameters, fit.names, fit.records),
        opposed_signs(motor, float(sigma)),
    )
    every = [*(f for f in physical if f is not None), *faults, *fit.findings]
    fit = replace(fit, findings=by_evidence(every))
    return replace(
        fit,
        warnings=(*fit_warnings(fit, reason, scatter), *warnings, *refused),
        impossible=(*impossible(fit), *refused),
    )
