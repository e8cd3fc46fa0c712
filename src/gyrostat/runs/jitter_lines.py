"""Lines on metrics of the kind `jitter`: wheels that are faster than their structure is known."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from gyrostat.core.text import plain
from gyrostat.core.unit_table import RPM
from gyrostat.scenario.kinds.metric.jitter import JitterKind
from gyrostat.scenario.scenario import Scenario


def fast_wheels(scenario: Scenario) -> list[str]:
    """Line on each metric whose structure is not known up to the greatest speed of the wheels."""
    metrics = [(name, _highest_speed(text)) for name, text in _metrics(scenario)]
    if not metrics:
        return []
    from gyrostat.runs.sight_in_run import greatest_speed  # imports SciPy, which takes long

    greatest = greatest_speed(scenario)
    return [
        f"warning: metric.{name}: found `speeds` up to {plain(most / RPM)} rpm, expected the "
        f"{plain(greatest / RPM)} rpm that the wheels can reach: a run that is faster in its "
        "windows has no value"
        for name, most in metrics
        if most < greatest
    ]


def unknown_jitter(scenario: Scenario, columns: Any) -> list[str]:
    """Line on each metric that complete runs lack.

    Args:
        scenario: Scenario of the runs.
        columns: Mapping of the columns of the table of runs, (runs,), or the values of one run.
    """
    lines = []
    for name, text in _metrics(scenario):
        values, status = (np.atleast_1d(columns[each]) for each in (name, "status"))
        lacking = np.isnan(values) & (status == 0)
        if np.any(lacking):
            runs = "" if len(values) == 1 else f" in {np.sum(lacking)} of {len(values)} runs"
            lines.append(
                f"warning: metric.{name}: found no value{runs}: a wheel is faster than "
                f"{plain(_highest_speed(text) / RPM)} rpm in its windows, or they have no sample"
            )
    return lines


def _metrics(scenario: Scenario) -> Iterator[tuple[str, str]]:
    """Name of each metric, and its structure as text."""
    texts = {text.path: text.text for text in scenario.texts}
    for part in scenario.parts:
        if part.section == "metric" and part.kind == JitterKind.name:
            yield part.name, texts[f"metric.{part.name}"]


def _highest_speed(text: str) -> float:
    """Highest speed up to which a structure is known, rad/s."""
    from gyrostat.microvibration.structure_text import structure_from  # imports SciPy

    return structure_from(text).speeds[1]
