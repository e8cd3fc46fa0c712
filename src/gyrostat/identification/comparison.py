"""Model comparison: fit, rank and cross-validate candidate friction models."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.identification.fit.loss import Loss, loss_named
from gyrostat.identification.fit.prediction import CurrentHold
from gyrostat.identification.fit.problem import Problem
from gyrostat.identification.judge.validation import validate
from gyrostat.identification.result.fit import Candidate, Fit
from gyrostat.identification.unsampled import solve
from gyrostat.telemetry import Record
from gyrostat.wheel.friction import FRICTION_MODELS
from gyrostat.wheel.friction_laws import Law, friction_law


def compare(
    records: Record | Sequence[Record],
    held_out: Sequence[Record] = (),
    *,
    models: Sequence[str | Law] | None = None,
    known: Fit | None = None,
    **options: Any,
) -> list[Candidate]:
    """Fit candidate friction models to the same records and rank them by BIC.

    Args:
        records: Records fitted together.
        held_out: Records predicted by every candidate and never fitted.
        models: Names or classes of the models; by default all of this package, and that of `known`.
        known: Fit of one of the models with the same arguments. It is reused if it is plain least
            squares, as the fits of the comparison are.
        options: Further arguments of `identify`, the same for all; names of parameters that a
            candidate does not have are ignored for it. The criteria use the same loss, and held-out
            records are predicted with the same hold of the current.

    Returns:
        The candidates, best BIC first, those without a valid fit last. The criteria take the noise
        of the best fit as known, which makes them comparable.

    Raises:
        InputError: A model or loss is unknown, or there is no record.
    """
    return candidates_of(Problem.of(records, **options), held_out, models=models, known=known)


def candidates_of(
    problem: Problem,
    held_out: Sequence[Record] = (),
    *,
    models: Sequence[str | Law] | None = None,
    known: Fit | None = None,
) -> list[Candidate]:
    """Candidates for the records of a problem; see `compare`."""
    loss = loss_named(problem.loss)
    usual = [*FRICTION_MODELS.values()]
    if known is not None and known.model not in usual:
        usual.append(known.model)
    laws = [friction_law(model) for model in models or usual]
    every = {p for law in (*laws, *usual) for p in law.dimensions()}
    outcomes: list[tuple[str, Fit | None, str]] = []
    for law in laws:
        name, absent = law.name, every - set(law.dimensions())
        if known is not None and known.model.name == name and not known.effects:
            outcomes.append((name, known, ""))
            continue
        try:
            names = {n: n for n in problem.asked - absent}
            candidate = replace(problem.named(names), model=law, white_noise=True)
            outcomes.append((name, solve(candidate), ""))
        except InputError as error:
            outcomes.append((name, None, str(error)))
    valid = [fit for _, fit, _ in outcomes if fit is not None and fit.converged]
    if not valid:
        return [Candidate(name, fit, None, None, None, why) for name, fit, why in outcomes]
    noise = min(valid, key=lambda f: f.speed_sigma).speed_sigmas
    size = {id(f): (_deviance(f, noise, loss), len(f.names)) for f in valid}
    aic = {key: deviance + 2.0 * count for key, (deviance, count) in size.items()}
    bic = {key: d + count * np.log(valid[0].samples) for key, (d, count) in size.items()}
    rows = []
    for name, fit, why in outcomes:
        if fit is None or not fit.converged:
            rows.append(Candidate(name, fit, None, None, None, why or "did not converge"))
            continue
        try:
            held_out_rms = _held_out(fit, held_out, problem.current_hold)
        except InputError as error:
            held_out_rms, why = None, str(error)
        relative = [float(c[id(fit)] - min(c.values())) for c in (aic, bic)]
        rows.append(Candidate(name, fit, relative[0], relative[1], held_out_rms, why))
    return sorted(rows, key=lambda row: np.inf if row.bic is None else row.bic)


def _deviance(fit: Fit, noise: Sequence[float], loss: Loss) -> float:
    """Twice the loss of all residuals, which the fit minimises."""
    parts = zip(fit.records, fit.residuals, noise, strict=True)
    return 2.0 * sum(float(np.sum(loss.value(r[record.valid] / n))) for record, r, n in parts)


def _held_out(fit: Fit, records: Sequence[Record], current_hold: CurrentHold) -> float | None:
    if not records:
        return None
    wheel = {n: v for n, v in fit.parameters.items() if not n.startswith("initial_speed")}
    validations = [validate(fit.model, wheel, r, current_hold=current_hold) for r in records]
    total = sum(v.samples for v in validations)
    return float(np.sqrt(sum(v.rms_speed**2 * v.samples for v in validations) / total))
