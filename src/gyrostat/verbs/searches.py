"""Searches among the runs of a scenario, for the verbs `campaign` and `tune`."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.scenario import Scenario
    from gyrostat.search.execute import Options, Question
    from gyrostat.search.rare import RareFailure
    from gyrostat.search.worst_case import WorstCase


def check_native(option: str, device: str, engine: str) -> None:
    """Check that a search is to use the native engine, and configure it; raises `InputError`."""
    from gyrostat.runs.fingerprint import FLAGS, engine_record, use_engine

    if device != "cpu" or engine not in ("auto", "native"):
        found = f"--device {device}" if device != "cpu" else f"--engine {engine}"
        raise InputError(f"{option}: found {found}, expected the native engine")
    use_engine(engine_record("cpu", FLAGS["cpu"]))


def question_of(
    scenario: "Scenario",
    runs: int,
    seed: int,
    rare: str | None,
    worst_case: str,
    within: str | None,
    say: Say,
) -> "RareFailure | WorstCase":
    """Create the search that the options of `gyrostat.campaign` request.

    Raises:
        InputError: An option cannot be used, or there are too few runs.
    """
    from gyrostat.search.condition import Condition
    from gyrostat.search.rare import ENOUGH, FEW, RareFailure
    from gyrostat.search.worst_case import WorstCase

    if rare is None:
        question = WorstCase.of(scenario, worst_case, within or "3sigma")
    else:
        question = RareFailure(Condition.parse(rare, scenario, "--rare"))
    question.searches(runs, seed)  # too few runs are an error
    if rare is not None and runs < ENOUGH:
        say(f"--runs {runs}: {FEW}")
    return question


def search(
    question: "RareFailure | WorstCase",
    scenario: "Scenario",
    folder: Path,
    *about: Any,
    **further: Any,
) -> "xr.Dataset":
    """Carry out a search; returns what `gyrostat.campaign` does. See `run_question`."""
    from gyrostat.campaigns import campaign_runs
    from gyrostat.search.rare import RareFailure

    content = run_question(scenario, folder, question, *about, **further)
    if isinstance(question, RareFailure):
        result = {name: content[name] for name in ("probability", "low", "high", "below")}
    else:
        from gyrostat.search.worst_case import found_worst

        worst = found_worst(folder).worst
        result = {"run": worst.number, "worst": worst.response, "noise_share": worst.noise_share}
    return campaign_runs(folder).assign_attrs(result, doubts=tuple(content["doubts"]))


def run_question(
    scenario: "Scenario",
    folder: Path,
    question: "Question",
    options: "Options",
    say: Say,
    on_progress: Callable[[int, int], None] | None,
    command: str,
    variants: "Sequence[Scenario]" = (),
    address: str | None = None,
) -> dict[str, Any]:
    """Carry out a search and write its report; returns the content of report.json.

    See `gyrostat.search.execute.run_search` and `gyrostat.reports.campaign.write_campaign`.
    """
    from gyrostat.reports.campaign import write_campaign
    from gyrostat.search.execute import run_search

    about = {"on_progress": on_progress, "say": say, "variants": variants}
    run_search(scenario, folder, question, options, **about)
    return json.loads(write_campaign(folder, command=command, say=say, address=address))
