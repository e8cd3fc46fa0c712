"""Worst runs of a campaign."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.campaigns.store import Store


def worst_runs(store: Store, count: int, metric: str) -> list[int]:
    """Indices of the worst runs: first incomplete runs, then those with the largest metric.

    A run that never settles is worse than one that does. A run without another metric, such as the
    crossing peak of a run without zero crossing, comes last. Among equal values, the run with the
    larger maximum pointing error is worse.
    """
    if count == 0:
        return []
    columns = store.columns()
    none = np.inf if metric.split(".")[-1] == "settling" else -np.inf
    incomplete = columns["status"] != 0
    value = np.array(columns[metric], float)
    value[np.isnan(value)] = none
    value[incomplete] = np.inf
    rows = np.arange(min(count, len(value)))
    if count < len(value):
        # the first ones of all keys need not be sorted with all others
        limit = np.partition(value, -count)[-count]
        above, rows = np.flatnonzero(value > limit), np.flatnonzero(value == limit)
        for key in ("ended", "error_max"):
            if len(above) + len(rows) == count:
                break
            size = _badness(columns, key, incomplete, rows)
            limit = np.partition(size, len(above) - count)[len(above) - count]
            above, rows = np.concatenate([above, rows[size > limit]]), rows[size == limit]
        rows = np.concatenate([above, rows[: count - len(above)]])
    keys = [_badness(columns, key, incomplete, rows) for key in ("error_max", "ended")]
    order = np.lexsort((rows, *(-key for key in keys), -value[rows]))
    return columns["run"][rows[order]][:count].tolist()


def _badness(columns: Mapping[str, Any], key: str, incomplete: Any, rows: Any) -> Any:
    """Further keys of the order of the worst runs, larger for worse ones, of some runs."""
    values = columns[key][rows]
    if key == "ended":
        return np.where(incomplete[rows], -values, 0.0)
    return np.nan_to_num(values)
