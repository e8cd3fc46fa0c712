"""Page of a campaign that flies its runs again."""

from collections.abc import Callable

import numpy as np

from gyrostat.campaigns import Campaign, Store
from gyrostat.campaigns.draws import draw
from gyrostat.campaigns.engine import fly
from gyrostat.campaigns.worst import worst_runs
from gyrostat.core.engines import engine_named
from gyrostat.reports.campaign_run import run_page
from gyrostat.reports.fly import CLOUD, fly_content
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.orbits import has_own_orbits
from gyrostat.scenario.metrics.results import percentile_name

WORST = 3
"""Number of worst runs in the page."""


def fly_page(store: Store, campaign: Campaign, command: str, say: Callable[[str], None]) -> str:
    """HTML page with the nominal run, the worst runs and the first ones of a campaign.

    Args:
        store: Folder of the campaign.
        campaign: Campaign; no search.
        command: Command line that produced the page.
        say: Called with each line for the user.
    """
    scenario = Scenario.from_text(campaign.scenario)
    metric = percentile_name(scenario.percentiles[-1])
    numbers = {run: f"run {run}, worst {metric}" for run in worst_runs(store, WORST, metric)}
    if not has_own_orbits(scenario.dispersed):  # whose tables are large
        first = range(min(CLOUD, campaign.runs)) if scenario.dispersions else ()
        numbers |= {run: f"run {run}" for run in first if run not in numbers}
    values, _ = draw(scenario, campaign.seed, np.array([*numbers], np.int64))
    rows = zip(numbers.items(), values, strict=True)
    runs = {"nominal": (0, None), **{name: (run, row) for (run, name), row in rows}}
    engine = engine_named("auto", say, "--fly")
    nominal = fly(scenario, campaign.seed, None, keep=[0], engine=engine)
    assert nominal.histories is not None
    history = nominal.histories.of_run(0).arrays()
    row = {name: column[0].item() for name, column in nominal.columns.items()}
    flown = fly_content(scenario, campaign.seed, runs, say)
    return run_page(scenario, row, history, f"{scenario.name}: fly its runs", command, flown)
