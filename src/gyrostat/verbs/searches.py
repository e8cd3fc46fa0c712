"""Searches among the runs of a scenario, for the verb `campaign`."""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Say

if TYPE_CHECKING:
    import xarray as xr

    from gyrostat.campaigns import Scenario
    from gyrostat.campaigns.search.execute import Options, Question


class Search(NamedTuple):
    """Options that all searches share; see `gyrostat.campaign`."""

    scenario: "Scenario"
    folder: Path
    runs: int
    seed: int
    workers: int | None
    worst: int
    force: bool
    verify: bool
    device: str
    engine: str
    on_progress: Callable[[int, int], None] | None
    say: Say
    command: str

    def check(self, option: str) -> None:
        """Check that the native engine is to be used, and configure it; raises `InputError`."""
        from gyrostat.campaigns.fingerprint import FLAGS, engine_record, use_engine

        if self.device != "cpu" or self.engine == "jax":
            device = self.device != "cpu"
            found = f"--device {self.device}" if device else "--engine jax"
            raise InputError(f"{option}: found {found}, expected the native engine")
        use_engine(engine_record("cpu", FLAGS["cpu"]))

    def run(self, question: "Question") -> "tuple[xr.Dataset, dict[str, Any]]":
        """Carry out the search and write its report; its runs and the content of report.json."""
        from gyrostat.campaigns import campaign_runs
        from gyrostat.campaigns.search.execute import Options

        workers = self.workers or len(os.sched_getaffinity(0))
        options = Options(self.runs, self.seed, workers, self.worst, self.force, self.verify)
        about = options, self.on_progress, self.say, self.command
        content = run_question(self.scenario, self.folder, question, *about)
        return campaign_runs(self.folder), content

    def failures(self, failure: str) -> "xr.Dataset":
        """Estimate the probability of a failure; see `gyrostat.campaign`."""
        self.check("--rare")
        from gyrostat.campaigns.search.condition import Condition
        from gyrostat.campaigns.search.rare import ENOUGH, FEW, RareFailure

        question = RareFailure(Condition.parse(failure, self.scenario, "--rare"))
        question.searches(self.runs, self.seed)  # too few runs are an error
        if self.runs < ENOUGH:
            self.say(f"--runs {self.runs}: {FEW}")
        made, found = self.run(question)
        about = {name: found[name] for name in ("probability", "low", "high")}
        return made.assign_attrs(about, doubts=tuple(found["doubts"]))

    def worst_case(self, metric: str, within: str) -> "xr.Dataset":
        """Search for the worst case of a metric; see `gyrostat.campaign`."""
        self.check("--worst-case")
        from gyrostat.campaigns.search.worst_case import WorstCase, found_worst

        made, _ = self.run(WorstCase.of(self.scenario, metric, within))
        found = found_worst(self.folder).worst
        about = {"run": found.number, "worst": found.response, "noise_share": found.noise_share}
        return made.assign_attrs(about)


def run_question(
    scenario: "Scenario",
    folder: Path,
    question: "Question",
    options: "Options",
    on_progress: Callable[[int, int], None] | None,
    say: Say,
    command: str,
) -> dict[str, Any]:
    """Carry out a search and write its report; returns the content of report.json."""
    from gyrostat.campaigns.search.execute import run_search
    from gyrostat.reports.campaign import write_campaign

    run_search(scenario, folder, question, options, on_progress=on_progress, say=say)
    return json.loads(write_campaign(folder, command=command, say=say))
