"""Findings of a diagnosis, their evidence, and the options that include them in a fit."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field

from gyrostat.core.pictured import Described

INCLUDED = "already included in values and sigma"
OPTIONS = {
    "speed_lag": INCLUDED,
    "viscous_drift": INCLUDED,
    "viscous_variation": INCLUDED,
    "coulomb_drift": INCLUDED,
    "coulomb_variation": INCLUDED,
    "current_rounding": INCLUDED,
    "current_steps": INCLUDED,
    "crossing_ripple": INCLUDED,
    "torque_walk": INCLUDED,
    "current_offset": "--free current_bias",
    "asymmetry": "--model directional",
    "viscous_asymmetry": "--model directional",
    "stribeck": "--model stribeck",
    "outliers": "--loss student",
    "unsigned_current": "--unsigned-current with a setpoint, or --model auto",
    "unsigned_speed": "--unsigned-speed",
    "units": "--units",
    "opposed_signs": "reverse the sign of one of the two columns",
    "quantum": "edge times or an encoder angle in place of counts",
}
"""Effect -> option that includes it; `--model auto` for all others."""


@dataclass(frozen=True)
class Finding(Described):
    """Effect found in the records, with the effects that cannot be distinguished from it.

    Attributes:
        names: Identifiers, the most likely one first.
        titles: Titles in reports.
        value: Size of the first effect; the largest one of several coefficients.
        sigma: Standard deviation of the size; None for a random torque.
        unit: Unit of value and sigma; "1" for fractions.
        significance: Square root of the decrease of the deviance, or of a similar statistic; None
            if the finding follows from physics and not from statistics.
        evidence: Decrease of the Bayesian criterion (BIC); None in the same case.
        shifts: Name -> change of the least-squares estimate if the effect is included, SI.
    """

    names: tuple[str, ...]
    titles: tuple[str, ...]
    value: float
    sigma: float | None
    unit: str
    significance: float | None
    evidence: float | None
    shifts: Mapping[str, float] = field(default_factory=dict)

    @property
    def options(self) -> tuple[str, ...]:
        """Options that include the effects in a fit, without duplicates."""
        every = [OPTIONS.get(name, "--model auto") for name in self.names]
        return tuple(dict.fromkeys(every))

    def to_dict(self) -> dict[str, object]:
        """Row of the diagnosis in fit.json."""
        lists = {name: list(getattr(self, name)) for name in ("names", "titles", "options")}
        return {**asdict(self), **lists}


def fault_finding(
    name: str,
    title: str,
    value: float = 1.0,
    evidence: float | None = None,
    *,
    unit: str = "1",
    significance: float | None = None,
) -> Finding:
    """Finding of a fault of a record or of its units, whose size has no standard deviation.

    Args:
        name: Identifier.
        title: Title in reports.
        value: Size of the fault.
        evidence: Decrease of the Bayesian criterion (BIC); None if the finding follows from physics
            and not from statistics.
        unit: Unit of the value.
        significance: See `Finding`; by default the square root of the evidence.
    """
    if significance is None and evidence is not None:
        significance = math.sqrt(evidence)
    return Finding((name,), (title,), value, None, unit, significance, evidence)


@dataclass(frozen=True)
class Score(Described):
    """Score test of one candidate, given the effects that were found.

    Attributes:
        name: Identifier.
        title: Title in reports.
        value: Size that it would have; the most significant one of several coefficients.
        sigma: Standard deviation of the size, the resolution of the record.
        unit: Unit of value and sigma.
        significance: Square root of the decrease of the deviance if it is added.
    """

    name: str
    title: str
    value: float
    sigma: float
    unit: str
    significance: float


def by_evidence(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings in order: those from physics first, then those with most evidence."""

    def rank(finding: Finding) -> float:
        return -math.inf if finding.evidence is None else -finding.evidence

    return tuple(sorted(findings, key=rank))
