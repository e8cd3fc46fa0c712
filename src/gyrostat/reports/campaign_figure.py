"""Picture of a finished campaign or search."""

from pathlib import Path

from matplotlib.figure import Figure

from gyrostat.campaigns import Store
from gyrostat.reports.campaign_charts import histograms, shown_metrics
from gyrostat.reports.campaign_content import campaign_content
from gyrostat.reports.chart_figure import figure_of
from gyrostat.reports.error_budget import budget_figure
from gyrostat.reports.rare import exceedance_figure
from gyrostat.reports.tuning import front_figure
from gyrostat.reports.worst_case import progress_figure
from gyrostat.scenario import Scenario
from gyrostat.search.error_budget import BUDGET
from gyrostat.search.found_budget import found_budget
from gyrostat.search.rare import RARE, found_failures
from gyrostat.search.tuning import FREE, found_tuning
from gyrostat.search.worst_case import WORST_CASE, found_worst

MOST_METRICS = 8
"""Largest number of histograms."""


def campaign_figure(store: Store) -> Figure:
    """Picture of a finished campaign or search; see `runs_figure`."""
    campaign, folder = store.known(), Path(store.folder)
    kind = None if campaign.search is None else next(iter(campaign.search))
    if kind == RARE:
        return exceedance_figure(Scenario.from_text(campaign.scenario), found_failures(folder))
    if kind == WORST_CASE:
        return progress_figure(found_worst(folder))
    if kind == BUDGET:
        return budget_figure(found_budget(folder))
    if kind == FREE:
        return front_figure(found_tuning(folder))
    scenario, columns = Scenario.from_text(campaign.scenario), store.columns()
    content = campaign_content(scenario, campaign, columns, store)
    varying = shown_metrics(scenario, columns)
    names = [name for name in content["headline"] if name in varying]
    names += [name for name in varying if name not in names]
    return figure_of(histograms(scenario, columns, dict.fromkeys(names[:MOST_METRICS], ())))
