"""Values of the runs inside the page of a campaign, for the selection of runs in histograms."""

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.reports.page_units import page_unit
from gyrostat.scenario import Scenario
from gyrostat.scenario.kinds.registry import numbers_of
from gyrostat.scenario.metrics.results import metrics_of

MOST_BYTES = 3_500_000
"""Size that the values take in a page."""
_AT_ONCE = 1_000_000
"""Number of runs that are searched at a time."""
_EXTREMES = 20
"""Number of largest and of smallest values of each metric whose runs are always kept."""


def rounded(values: Vector) -> NDArray[np.float32]:
    """Values with the 16 significant bits that a page keeps, some five decimal digits."""
    bits = np.asarray(values, np.float32).view(np.uint32)
    return ((bits + np.uint32(0x80)) & np.uint32(0xFFFFFF00)).view(np.float32)


def packed(values: Vector) -> str:
    """Values as text, four characters each: three bytes of a rounded number, the highest first."""
    words = rounded(values).view(np.uint32).astype(">u4")
    return base64.b64encode(words.view(np.uint8).reshape(-1, 4)[:, :3].tobytes()).decode()


def run_table(
    scenario: Scenario, columns: Mapping[str, Vector], names: Sequence[str], driving: Sequence[str]
) -> dict[str, Any]:
    """Values of the runs for the script of the page.

    Args:
        scenario: Scenario of the campaign.
        columns: Columns of the table of runs.
        names: Metrics whose histograms are shown.
        driving: Dispersed keys, the strongest first.

    Returns:
        `columns`: name, unit and kind of each; `runs`: numbers of the runs, or None for all from 0
        on; `count`: number of runs of the campaign; `values`: the columns one after the other, see
        `packed`, NaN for missing values.
    """
    metrics, numbers = metrics_of(scenario), numbers_of(scenario)
    descriptions, parts = [], []
    count = len(columns["status"])
    selection = _pick(columns, names, MOST_BYTES // (4 * max(len(names) + len(driving), 1)))
    for name in (*names, *driving):
        is_metric = name in metrics
        si_unit = metrics[name].unit if is_metric else numbers[name].unit
        scale, unit = page_unit(name, si_unit)
        descriptions.append({"name": name, "unit": unit, "metric": is_metric})
        parts.append(packed(scale * columns[name][selection]))
    runs = None if len(selection) == count else selection.tolist()
    return {"columns": descriptions, "runs": runs, "count": count, "values": "".join(parts)}


def _pick(columns: Mapping[str, Vector], names: Sequence[str], most: int) -> NDArray[np.int64]:
    """Runs whose values are kept: those with the extreme values of each metric, then the first."""
    count = len(columns["status"])
    if count <= most:
        return np.arange(count)
    pairs = [_extremes(columns[name]) for name in names]
    extremes: dict[int, None] = {}
    for k in range(_EXTREMES):
        for of_metric in pairs:
            extremes |= dict.fromkeys(of_metric[k] if k < len(of_metric) else ())
    return np.sort(np.array(list(extremes | dict.fromkeys(range(most)))[:most]))


def _extremes(values: Vector) -> list[tuple[int, int]]:
    """Runs with the largest and the smallest values, in pairs: the most extreme ones first."""
    finite = values[np.isfinite(values)]
    count = min(_EXTREMES, len(finite))
    if count == 0:
        return []
    finite.partition((count - 1, len(finite) - count))
    low, high = finite[count - 1], finite[-count]
    del finite
    small, large = (
        _first(values, values < low, low, count),
        _first(values, values > high, high, count),
    )
    small = small[np.argsort(values[small], kind="stable")]
    large = large[np.argsort(-values[large], kind="stable")]
    return list(zip(large.tolist(), small.tolist(), strict=True))


def _first(values: Vector, is_beyond: NDArray[np.bool_], limit: float, count: int) -> NDArray:
    """Runs beyond a limit, and the first of those that are at it, in all `count`."""
    parts = [np.flatnonzero(is_beyond & np.isfinite(values))]
    for first in range(0, len(values), _AT_ONCE):
        if sum(map(len, parts)) >= count:
            break
        parts.append(first + np.flatnonzero(values[first : first + _AT_ONCE] == limit))
    return np.sort(np.concatenate(parts)[:count])
