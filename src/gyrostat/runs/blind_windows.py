"""Windows of a run, or of many, in which the star tracker saw too rarely."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gyrostat.core.text import plain
from gyrostat.scenario.metrics.tracker_view import LEAST, heads_of
from gyrostat.scenario.scenario import Scenario


def blind_windows(scenario: Scenario, columns: Mapping[str, Any]) -> list[str]:
    """A line for each window with a `tracker_availability` below `metrics.least_availability`.

    Args:
        scenario: Scenario of the runs.
        columns: Columns of the table of runs, (runs,), or the values of one run.
    """
    if not heads_of(scenario.parts):
        return []
    least = scenario.values[LEAST]
    lines = []
    for window in scenario.windows:
        names = (f"{window.name}.{name}" for name in ("tracker_availability", "tracker_outage"))
        share, outage = (np.atleast_1d(columns[name]) for name in names)
        low = share < least
        if not np.any(low):
            continue
        runs = "" if len(share) == 1 else f" in {np.sum(low)} of {len(share)} runs"
        at_least = "" if len(share) == 1 else "at least "
        lines.append(
            f"window {window.name}: found a star tracker that sees less than "
            f"{percent(least)} of the time{runs}: {at_least}{percent(np.nanmin(share))}, longest "
            f"outage {plain(np.nanmax(outage))} s (metrics.least_availability)"
        )
    return lines


def percent(share: float) -> str:
    """Share in percent, three digits."""
    return f"{100.0 * share:.3g} %"
