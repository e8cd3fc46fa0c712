"""Kept runs of a campaign inside its page: curves, motion and values."""

from collections.abc import Sequence
from typing import Any

from gyrostat.campaigns import Store
from gyrostat.campaigns.run_table import RunTable
from gyrostat.reports.campaign_run import drawn_rows, metric_rows, run_verdict
from gyrostat.reports.replay import replay_data
from gyrostat.reports.run_charts import run_charts
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.orbits import planned_orbit

MOST_RUNS = 8
"""Largest number of runs in a page."""
MOST_POINTS = 800
"""Largest number of points of their curves."""
FRAMES = 300
"""Number of samples of their motion."""


def kept_runs(
    scenario: Scenario,
    columns: RunTable,
    store: Store,
    wanted: Sequence[int],
    ranked: str,
) -> list[dict[str, Any]]:
    """Content of the page on each kept run.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        store: Folder of the campaign.
        wanted: Numbers of runs whose histories are kept, the most important first.
        ranked: Metric that ranks them.
    """
    import h5netcdf  # slow to import

    sections, orbit = [], planned_orbit(scenario) if wanted else None
    for run in wanted[:MOST_RUNS]:
        values = columns.row(run)
        with h5netcdf.File(store.history(run)) as history:
            sections.append(
                {
                    "run": run,
                    "file": f"runs/{store.history(run).name}",
                    "verdict": run_verdict(values),
                    "ranked": values[ranked],
                    "charts": run_charts(scenario, values, history, f"run{run}", MOST_POINTS),
                    "motion": replay_data(scenario, values, history, orbit, FRAMES),
                    "rows": metric_rows(scenario, values),
                    "drawn": drawn_rows(scenario, values),
                }
            )
    return sections
