"""Runs of a finished campaign as labelled arrays."""

from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.campaigns.store import Store
from gyrostat.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr


def campaign_runs(folder: str | Path) -> "xr.Dataset":
    """Read the table of a finished campaign.

    Args:
        folder: Folder of the campaign.

    Returns:
        Variables over `run`, with units and meanings: every drawn parameter under its key, such as
        "wheel.a.coulomb", every metric (NaN if a run has none), `status` and `ended` (s). The
        attributes `folder`, `scenario` and `seed` identify the campaign. The unit of a column of
        `to_dataframe()` is the attribute `units` of the variable with its name. Of a large table
        (`gyrostat.campaigns.run_table.LARGE`), a variable is read from the file whenever its
        values are used, as by `xarray.open_dataset(..., cache=False)`; `load()` reads all of them.

    Raises:
        InputError: The folder has no finished campaign.
    """
    from pandas import RangeIndex

    from gyrostat.campaigns.lazy_runs import lazy_column
    from gyrostat.core.pictured_datasets import Runs, mark_whole
    from gyrostat.scenario.kinds.registry import numbers_of
    from gyrostat.scenario.metrics.results import metrics_of
    from gyrostat.simulation import status_attributes

    store = Store(Path(folder))
    campaign, table = store.known(), store.columns()
    scenario = Scenario.from_text(campaign.scenario)
    numbers = numbers_of(scenario)
    attributes = {
        **{
            key: {"units": numbers[key].unit, "long_name": f"drawn {key}"}
            for key in scenario.dispersed
        },
        **{
            name: {"units": metric.unit, "long_name": metric.meaning}
            for name, metric in metrics_of(scenario).items()
        },
        "ended": {"units": "s", "long_name": "Time until which the run is valid."},
        "status": status_attributes(),
    }
    variables = {
        name: (
            "run",
            lazy_column(table, name) if table.is_large else table.read(name),
            attributes.get(name, {}),
        )
        for name in table
        if name != "run"
    }
    about = {"scenario": scenario.name, "folder": str(folder), "seed": campaign.seed}
    # a campaign has all runs in order; a search may have other numbers
    run = RangeIndex(table.runs) if campaign.search is None else table.read("run")
    runs = Runs(variables, {"run": run}, about)
    mark_whole(runs)
    return runs
