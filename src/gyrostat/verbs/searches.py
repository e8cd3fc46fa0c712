"""Searches among the runs of a scenario, for the verbs `campaign` and `tune`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.campaigns import Scenario
    from gyrostat.campaigns.search.execute import Options, Question


def check_native(option: str, device: str, engine: str) -> None:
    """Check that a search is to use the native engine, and configure it; raises `InputError`."""
    from gyrostat.campaigns.fingerprint import FLAGS, engine_record, use_engine

    if device != "cpu" or engine == "jax":
        found = f"--device {device}" if device != "cpu" else "--engine jax"
        raise InputError(f"{option}: found {found}, expected the native engine")
    use_engine(engine_record("cpu", FLAGS["cpu"]))


def failures(
    failure: str, scenario: "Scenario", folder: Path, options: "Options", say: Say, *about: Any
) -> "xr.Dataset":
    """Estimate the probability of a failure; see `gyrostat.campaign` and `run_question`."""
    from gyrostat.campaigns import campaign_runs
    from gyrostat.campaigns.search.condition import Condition
    from gyrostat.campaigns.search.rare import ENOUGH, FEW, RareFailure

    question = RareFailure(Condition.parse(failure, scenario, "--rare"))
    question.searches(options.runs, options.seed)  # too few runs are an error
    if options.runs < ENOUGH:
        say(f"--runs {options.runs}: {FEW}")
    found = run_question(scenario, folder, question, options, say, *about)
    told = {name: found[name] for name in ("probability", "low", "high")}
    return campaign_runs(folder).assign_attrs(told, doubts=tuple(found["doubts"]))


def worst_case(
    metric: str, within: str, scenario: "Scenario", folder: Path, *about: Any
) -> "xr.Dataset":
    """Search for the worst case of a metric; see `gyrostat.campaign` and `run_question`."""
    from gyrostat.campaigns import campaign_runs
    from gyrostat.campaigns.search.worst_case import WorstCase, found_worst

    run_question(scenario, folder, WorstCase.of(scenario, metric, within), *about)
    found = found_worst(folder).worst
    told = {"run": found.number, "worst": found.response, "noise_share": found.noise_share}
    return campaign_runs(folder).assign_attrs(told)


def run_question(
    scenario: "Scenario",
    folder: Path,
    question: "Question",
    options: "Options",
    say: Say,
    on_progress: Callable[[int, int], None] | None,
    command: str,
) -> dict[str, Any]:
    """Carry out a search and write its report; returns the content of report.json."""
    from gyrostat.campaigns.search.execute import run_search
    from gyrostat.reports.campaign import write_campaign

    run_search(scenario, folder, question, options, on_progress=on_progress, say=say)
    return json.loads(write_campaign(folder, command=command, say=say))
