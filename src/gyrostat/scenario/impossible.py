"""Numbers of a scenario that cannot exist together, and names that clash."""

from collections import Counter

from gyrostat.core.errors import InputError, placed
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.numbers import check_inertias
from gyrostat.scenario.relation import check_relations
from gyrostat.scenario.relations import nominal_relations, relations_of
from gyrostat.scenario.scenario import Scenario

COLUMNS = ("run", "status", "ended")
"""Columns of the table of runs beside metrics and drawn values."""


def check_possible(scenario: Scenario) -> None:
    """Validate numbers that concern several keys, and the names of windows.

    Raises:
        InputError: The body inertia is not above that of the rotors, values do not fulfil a
            relation, or a window has the name of a metric.
    """
    with placed("key body.inertia"):
        check_inertias(scenario.values, scenario.wheels, scenario.axes)
    check_relations(relations_of(scenario), scenario.values)
    check_relations(nominal_relations(scenario), scenario.values)
    _check_names(scenario)


def _check_names(scenario: Scenario) -> None:
    """Validate that no window has the name of a metric, and no two columns have one name."""
    metrics = metrics_of(scenario)
    for window in scenario.windows:
        names = {*COLUMNS, *(n for n, metric in metrics.items() if metric.window is None)}
        # metrics of a window have its name in front
        ends = {n.removeprefix(f"{window.name}.") for n in metrics if n.startswith(window.name)}
        if window.name in names or window.name in ends:
            raise InputError(
                f"key metrics.window[{window.name}].name: found the name of a metric, expected "
                "another one"
            )
    counts = Counter([*COLUMNS, *metrics, *scenario.dispersed])
    duplicates = [name for name, count in counts.items() if count > 1]
    if duplicates:
        raise InputError(
            f"key {duplicates[0]}: found two columns of this name in the table of runs, expected "
            "other names of windows and metrics"
        )
