"""Statistics of the metrics of a campaign, for report.json."""

import json
from typing import Any

import numpy as np

from gyrostat.campaigns import Campaign, Store
from gyrostat.campaigns.drivers import drivers_of
from gyrostat.campaigns.effects import MOST_RUNS, Effects, Inputs, find_effects, inputs_of
from gyrostat.campaigns.run_table import RunTable
from gyrostat.campaigns.summary import percentiles_of
from gyrostat.core.outputs import Manifest
from gyrostat.core.text import or_none
from gyrostat.core.types import Vector
from gyrostat.scenario import Scenario
from gyrostat.scenario.metrics.results import metrics_of

PERCENTILES = (50.0, 95.0, 99.7)
"""Percentiles of the runs in the report."""
STATISTICS_BY = "statistics_by"
"""Key of report.json: version of the code that computed the statistics of a large table."""


def stored_statistics(store: Store, known: Campaign, by: str) -> dict[str, Any] | None:
    """Statistics in the intact report.json of a campaign; None if other code computed them.

    The table of a campaign has the same bytes whenever it is written, so that they are those of
    the present table.

    Args:
        store: Folder of the campaign.
        known: The campaign.
        by: Version of the code.
    """
    name = "report.json"
    if not Manifest(store.folder).is_own(name, known.by):
        return None
    content = json.loads((store.folder / name).read_bytes())
    return content["metrics"] if content.get(STATISTICS_BY) == by else None


def metric_statistics(scenario: Scenario, known: Campaign, columns: RunTable) -> dict[str, Any]:
    """Percentiles, drivers and effects of each metric, by name."""
    known_metrics, keys = metrics_of(scenario), scenario.dispersed
    driving = drivers_of(columns.of(keys), columns.of(known_metrics))
    first = columns.head(MOST_RUNS)
    values = np.stack([first[name] for name in known_metrics], axis=1)
    inputs = inputs_of(scenario, known.seed, first)
    effects = None if isinstance(inputs, str) else find_effects(inputs, values)
    metrics: dict[str, Any] = {}
    for m, ((name, metric), rho, level) in enumerate(
        zip(known_metrics.items(), driving.rank_correlation.T, driving.chance_level, strict=True)
    ):
        order = [k for k in np.argsort(-np.abs(rho)) if np.isfinite(rho[k])]
        metrics[name] = {
            "unit": metric.unit,
            "window": metric.window,
            **_percentiles(columns[name]),
            "chance_level": or_none(float(level)),
            "drivers": [
                {
                    "key": keys[k],
                    "rank_correlation": float(rho[k]),
                    "beyond_chance": bool(abs(rho[k]) > level),
                }
                for k in order
            ],
            "effects": {"why": inputs}
            if effects is None or isinstance(inputs, str)
            else _effects(inputs, effects[m]),
        }
    return metrics


def _percentiles(values: Vector) -> dict[str, Any]:
    """Number of runs that have a metric, and its percentiles over them."""
    estimates = zip(PERCENTILES, percentiles_of(values, PERCENTILES), strict=True)
    percentiles = [{"percent": percent, **each._asdict()} for percent, each in estimates]
    return {
        "runs": int(np.sum(np.isfinite(values))),
        "percentiles": [{k: or_none(v) for k, v in p.items()} for p in percentiles],
    }


def _effects(inputs: Inputs, effects: Effects) -> dict[str, Any]:
    """Sobol indices of a metric, the largest total index first."""
    order = [] if effects.why else np.argsort(-effects.total[:, 0], kind="stable").tolist()
    names = ("value", "low", "high")
    return {
        "q2": or_none(effects.q2),
        "runs": effects.runs,
        "runs_without_values": effects.without,
        "why": effects.why or None,
        "inputs": [
            {
                "keys": list(inputs.names[k]),
                "first": dict(zip(names, effects.first[k].tolist(), strict=True)),
                "total": dict(zip(names, effects.total[k].tolist(), strict=True)),
            }
            for k in order
        ],
    }
