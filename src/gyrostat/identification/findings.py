"""What a diagnosis says: findings with their evidence, and what includes them."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

INCLUDED = "values and sigma allow for it"
OPTIONS = {
    "speed_lag": INCLUDED,
    "viscous_drift": INCLUDED,
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
    "opposed_signs": "turn the sign of one of the two columns",
    "quantum": "edge times or an encoder angle in place of counts",
}
"""Effect -> what includes it; `--model auto` for all others."""


@dataclass(frozen=True)
class Finding:
    """An effect that the record shows, with those that cannot be told from it.

    Attributes:
        names: Identifiers, the most likely one first.
        titles: What a report calls them.
        value: Size of the first; of several coefficients the largest one.
        sigma: Its standard deviation; None for a random torque.
        unit: Of value and sigma; "1" for shares.
        significance: Square root of the fall of the deviance, or of a statistic like it; None where
            physics tells, not statistics.
        evidence: Fall of the Bayesian criterion (BIC); None likewise.
        shifts: Name -> change of the least-squares estimate by including it, SI.
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
        """What includes the effects, each named once."""
        every = [OPTIONS.get(name, "--model auto") for name in self.names]
        return tuple(dict.fromkeys(every))

    def to_dict(self) -> dict[str, object]:
        """A row of the diagnosis in fit.json."""
        return {
            "names": list(self.names),
            "titles": list(self.titles),
            "value": self.value,
            "sigma": self.sigma,
            "unit": self.unit,
            "significance": self.significance,
            "evidence": self.evidence,
            "shifts": dict(self.shifts),
            "options": list(self.options),
        }


@dataclass(frozen=True)
class Score:
    """Score test of one candidate, beside what was found.

    Attributes:
        name: Identifier.
        title: What a report calls it.
        value: Size that it would have; of several coefficients the most significant one.
        sigma: Its standard deviation: what the record could show of it.
        unit: Of value and sigma.
        significance: Square root of the fall of the deviance by adding it.
    """

    name: str
    title: str
    value: float
    sigma: float
    unit: str
    significance: float


def by_evidence(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings, those that physics tells first, then the one with most evidence."""

    def rank(finding: Finding) -> float:
        return -math.inf if finding.evidence is None else -finding.evidence

    return tuple(sorted(findings, key=rank))
