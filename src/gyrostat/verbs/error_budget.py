"""Verb `budget`: what the pointing error is made of."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.verbs.arguments import Say, opener_of, silent
from gyrostat.verbs.progress import shown
from gyrostat.verbs.scenario_check import say_unlikely, scenario_of

if TYPE_CHECKING:
    from gyrostat.scenario import Scenario
    from gyrostat.search.budget_result import ErrorBudget


def budget(
    scenario: "Scenario | str | Path",
    out: "str | Path",
    *,
    runs: int = 128,
    seed: int = 0,
    metric: str | Iterable[str] = (),
    orders: int = 0,
    window: str | Iterable[str] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    verify: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
    say: Say = silent,
    command: str = "gyrostat.budget",
    **changes: Any,
) -> "ErrorBudget":
    """Split the pointing error by its sources, from runs with sources switched off.

    Every set of sources has the same draws and noise. The index of each pointing requirement of the
    scenario is split; without one, the absolute error in each window of its metrics, and the
    relative error over the exposure time of the window; without windows, that of the whole run.

    Args:
        scenario: Scenario, or path of scenario.toml.
        out: Folder for the runs, report.html and report.json.
        runs: Number of runs with each set of sources, at least 16. With n sources there are
            2 n + 2 sets, and one for each property of the loop, such as its delay.
        seed: Seed of all draws.
        metric: Further metrics, of which the part that is missing without each source is given.
        orders: Number of orders in which the sources are switched on one after the other, even: the
            contributions are then Shapley values, which share out all interactions. 0: each source
            is switched on and off alone, and interactions of three and more have their own line.
        window: Window of the metrics, or "run", or several; for a scenario without requirements.
            None: all windows.
        workers: Number of threads; None: one for each core.
        scheduler: As for `campaign`.
        force: As for `campaign`.
        verify: As for `campaign`.
        on_progress: Function called with the number of runs done and the total number; None: a bar
            in a terminal or notebook.
        say: Function that receives each message for the user.
        command: Text that the report names as its origin.
        changes: Changes of the scenario, as for `simulate`.

    Returns:
        The budget: `indices` with the contributions of each source, rad², and their intervals.

    Raises:
        InputError: The scenario has no source of pointing error or no such metric, or options
            cannot be used.
    """
    from gyrostat.core.files import check_writable
    from gyrostat.search.error_budget import BudgetQuestion
    from gyrostat.search.execute import Options
    from gyrostat.search.found_budget import found_budget
    from gyrostat.verbs.searches import run_question

    folder = Path(out)
    check_writable(folder)
    definition = scenario_of(scenario, force=force, changes=changes)
    say_unlikely(definition, say)
    metrics = [metric] if isinstance(metric, str) else [*metric]
    windows = [window] if isinstance(window, str) else [*window]
    question = BudgetQuestion.of(definition, runs, metrics, orders, windows)
    total = len(question.sets) * runs
    say(f"{len(question.sources)} sources, {len(question.sets)} sets of {runs} runs: {total} runs")
    options = Options(total, seed, workers, 0, force, verify, opener_of(scheduler, say))
    about = say, shown(on_progress), command, question.variants
    run_question(question.scenario, folder, question, options, *about)
    return found_budget(folder)
