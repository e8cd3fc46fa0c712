"""Automatic model selection: include the effects that the diagnosis finds."""

from dataclasses import dataclass, replace

from gyrostat.core.errors import InputError
from gyrostat.identification.fit.prediction import SpeedPrediction
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.fit.stages import Progress
from gyrostat.identification.read.clipping import clipped_current, without_clipped
from gyrostat.identification.read.findings import Finding
from gyrostat.identification.read.signs import RESTORE, lost_sign
from gyrostat.identification.result.fit import Fit
from gyrostat.identification.unsampled import solve
from gyrostat.telemetry import Record
from gyrostat.wheel.friction_laws import friction_law

AUTO = "auto"
"""Model name that requests automatic selection."""
SIMPLEST = "viscous-coulomb"
"""First friction model."""
MOST_STEPS = 6
"""Largest number of included effects."""
DIRECTIONAL = ("asymmetry", "viscous_asymmetry")
COLUMNS = (
    "viscous_over_temperature",
    "coulomb_over_temperature",
    "clipped_current",
)
"""Effects that are included in the fit as nuisance parameters."""


@dataclass(frozen=True)
class _Choice:
    """Model choices of a fit.

    Attributes:
        model: Name of the friction model.
        free: Further estimated parameters.
        loss: Loss function of a residual.
        include: Effects included in the fit as nuisance parameters.
    """

    model: str = SIMPLEST
    free: tuple[str, ...] = ()
    loss: str = "quadratic"
    include: tuple[str, ...] = ()

    def with_finding(self, finding: Finding) -> "_Choice | None":
        """Choice that also includes a finding; None if no option includes it.

        If effects cannot be distinguished, the first one that has an option is included. A current
        offset is preferred to an asymmetry of friction, because it has only one parameter.
        """
        if "current_offset" in finding.names and "current_bias" not in self.free:
            return replace(self, free=(*self.free, "current_bias"))
        for name in finding.names:
            if name in DIRECTIONAL and self.model != "directional":
                return replace(self, model="directional")
            if name == "stribeck" and self.model == SIMPLEST:
                return replace(self, model="stribeck")
            if name == "outliers" and self.loss == "quadratic":
                return replace(self, loss="student")
            joins = name in COLUMNS or name.startswith("ripple_")
            if joins and name not in self.include:
                return replace(self, include=(*self.include, name))
        return None

    def change(self, before: "_Choice") -> str:
        """Text of the difference from a narrower choice."""
        if self.free != before.free:
            return f"{self.free[-1]} estimated"
        if self.include != before.include:
            return f"{self.include[-1]} included"
        return f"{self.loss} loss" if self.loss != before.loss else f"model {self.model}"


def _restore(record: Record) -> Record:
    """Record with a missing sign restored and intervals of clipped current removed."""
    finding = lost_sign(record)
    if finding is not None:
        record = RESTORE[finding.names[0]](record) or record
    return record if clipped_current(record) is None else without_clipped(record)


def solve_automatically(problem: Problem, *, on_progress: Progress | None = None) -> Fit:
    """Identify a wheel with the model that its records support.

    Missing signs are restored and clipped currents are cut out. The simplest friction model is
    fitted. The effects that the diagnosis finds are then included, the one with most evidence
    first, until no further effect can be included. A step that leads to no valid wheel is undone.

    Args:
        problem: The problem; names that a model does not have are ignored for it.
        on_progress: As for `gyrostat.identification.identify`.

    Returns:
        The fit, with the choices made in `choices`.

    Raises:
        InputError: The records or the request cannot give an estimate.
    """
    problem = replace(problem, records=tuple(_restore(record) for record in problem.records))

    def fit_choice(choice: _Choice) -> Fit:
        law = friction_law(choice.model)
        names = SpeedPrediction(problem.records, law, "zero-order").names
        wider = replace(
            problem,
            model=law,
            free=[*{*problem.free, *choice.free}],
            loss=choice.loss,
            include=choice.include,
        )
        return solve(wider.named({name: name for name in names}), on_progress=on_progress)

    def attempt(choice: _Choice) -> Fit | None:
        try:
            fit = fit_choice(choice)
        except InputError:
            return None
        return fit if fit.converged else None

    choice, causes = _Choice(loss=problem.loss), []
    fit, failures = fit_choice(choice), set()
    for _ in range(MOST_STEPS):
        trials = [(f, choice.with_finding(f)) for f in fit.findings if f.names[0] not in failures]
        step = next(((f, c) for f, c in trials if c is not None), None)
        if step is None:
            break
        finding, wider = step
        richer = attempt(wider)
        if richer is None or (richer.impossible and not fit.impossible):
            failures.add(finding.names[0])
            continue
        causes.append(f"{wider.change(choice)} ({' or '.join(finding.titles)})")
        fit, choice = richer, wider
    return replace(fit, choices=(f"friction model {choice.model}", *causes))
