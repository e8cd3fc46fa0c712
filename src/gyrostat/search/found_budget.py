"""Budget of the pointing error from the runs of a finished search."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Matrix
from gyrostat.scenario.error_sources import never_switched
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.requirement import Requirement
from gyrostat.search.budget_result import ARCSEC, FEW, ErrorBudget, IndexBudget, Missing
from gyrostat.search.contributions import (
    WHOLE,
    contributions,
    missing_without,
    statistic_without,
)
from gyrostat.search.error_budget import FEWEST, BudgetQuestion
from gyrostat.search.execute import stored_search


def found_budget(folder: Path) -> ErrorBudget:
    """Read the budget of a finished search.

    Args:
        folder: Folder of the search.

    Raises:
        InputError: The folder has no finished search.
    """
    search = stored_search(folder)
    question = BudgetQuestion.stored(search.scenario, search.options())
    (response,), _ = search.results(question)
    return budget_of(question, response, search.campaign.seed)


def budget_of(question: BudgetQuestion, response: NDArray[np.float64], seed: int) -> ErrorBudget:
    """Budget from the responses of all runs, (sets, runs, columns)."""
    ended = np.isfinite(response[:, :, 0])
    valid = np.all(ended, axis=0)
    failed = {
        set_name(question, place): int(np.sum(~row))
        for place, row in enumerate(ended)
        if not all(row)
    }
    indices, metrics, without = [], [], {}
    for entry, values in _groups(question, response[:, valid, 1:]):
        name = entry.name if isinstance(entry, Requirement) else entry
        has_values = np.all(np.isfinite(values), axis=(0, 2))
        if not all(has_values):
            without[name] = int(np.sum(~has_values))
        if np.sum(has_values) < FEWEST:
            continue
        values = values[:, has_values]
        if isinstance(entry, Requirement):
            indices.append(_index_budget(question, entry, values, seed))
        else:
            unit = metrics_of(question.base)[entry].unit
            metrics.append(_missing(question, entry, unit, values[..., 0], None, seed))
    return ErrorBudget(
        scenario=question.base.name,
        runs=question.runs,
        valid=int(np.sum(valid)),
        failed=failed,
        without=without,
        sets=len(question.sets),
        seed=seed,
        indices=tuple(indices),
        metrics=tuple(metrics),
        not_switched=tuple(never_switched(question.base)),
        orders=len(question.places.orders),
        is_every_order=question.places.is_every_order,
    )


def set_name(question: BudgetQuestion, place: int) -> str:
    """Set of sources in words, after "runs did not end"."""
    each, sources = question.sets[place], question.sources
    if each.property:
        return f"without {each.property}"
    if len(each.off) == len(sources):
        return "with all sources off"
    if len(each.off) == len(sources) - 1 and len(sources) > 1:
        return f"with {next(s.name for s in sources if s not in each.off)} alone"
    return f"without {', '.join(s.name for s in each.off)}" if each.off else "with all sources"


def _groups(
    question: BudgetQuestion, response: NDArray[np.float64]
) -> Iterator[tuple[Requirement | str, NDArray[np.float64]]]:
    first = 0
    entries: list[Any] = [*question.base.requirements, *question.metrics]
    for entry, columns in zip(entries, question.columns().values(), strict=True):
        yield entry, response[..., first : first + len(columns)]
        first += len(columns)


def _index_budget(
    question: BudgetQuestion, requirement: Requirement, values: NDArray[np.float64], seed: int
) -> IndexBudget:
    square, means, size = values[..., 0], values[..., 1:-1], values[..., -1]
    places = [
        len(question.sets) - len(question.properties) + k for k in range(len(question.properties))
    ]
    worst = np.sort(square[WHOLE])[-max(1, round(FEW * square.shape[1])) :]
    is_ensemble = requirement.interpretation == "ensemble"
    what = (
        f"{requirement.index} that {100.0 * requirement.level:.12g} % of the runs do not exceed"
        if is_ensemble
        else f"{requirement.index} not exceeded in {100.0 * requirement.level:.12g} % of the time, "
        "mean of the runs"
    )
    if question.is_required:
        what += f"; required: {ARCSEC * requirement.value:.4g} arcsec"
    level = requirement.level if is_ensemble else None
    return IndexBudget(
        requirement,
        contributions(question.places, square, means),
        dict(zip(question.properties, missing_without(square, places), strict=True)),
        _missing(question, what, "rad", size, level, seed),
        bool(question.orders),
        float(np.sum(worst) / np.sum(square[WHOLE])) if np.any(square[WHOLE]) else 0.0,
    )


def _missing(
    question: BudgetQuestion, what: str, unit: str, values: Matrix, level: float | None, seed: int
) -> Missing:
    names = [*question.places.names, *question.properties]
    last = len(question.sets) - len(question.properties)
    places = [*question.places.without, *range(last, len(question.sets))]
    whole, *without = statistic_without(values[[WHOLE, *places]], level, seed)
    return Missing(what, unit, whole, dict(zip(names, without, strict=True)))
