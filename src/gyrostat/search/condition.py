"""Condition on a metric of a run, such as "error_max > 0.5 deg"."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.core.types import Vector
from gyrostat.core.units import SI_UNIT, ascii_number, parse_quantity
from gyrostat.scenario.metrics.results import metrics_of
from gyrostat.scenario.scenario import Scenario

_FORM = re.compile(r"\s*([^\s<>=]+)\s*([<>]=?)\s*(.+?)\s*", re.DOTALL)
NO_EVENT = "crossing_peak"
"""Metric that a run lacks if the event that it measures does not occur."""


@dataclass(frozen=True)
class Condition:
    """Condition on a metric.

    Attributes:
        metric: Name of the metric.
        above: Whether the condition holds above the bound; otherwise below.
        bound: Bound, SI unit of the metric.
        text: Text of the condition.
    """

    metric: str
    above: bool
    bound: float
    text: str

    @classmethod
    def parse(cls, text: str, scenario: Scenario, where: str) -> Self:
        """Parse METRIC > QUANTITY or METRIC < QUANTITY; a bare number is in SI.

        Args:
            text: Condition.
            scenario: Scenario with the metric.
            where: Option, for messages.

        Raises:
            InputError: The text is no condition, the scenario has no such metric, or the quantity
                has another dimension.
        """
        match = _FORM.fullmatch(text)
        if match is None or "=" in match[2]:
            raise InputError(f"{where}: found {text!r}, expected METRIC > VALUE or METRIC < VALUE")
        metric = known_metric(match[1], scenario, where)
        bound = quantity(match[3], metrics_of(scenario)[metric].unit, f"{where} {metric}")
        return cls(metric, match[2] == ">", bound, f"{metric} {match[2]} {match[3]}")

    def response(self, columns: Mapping[str, Vector]) -> Vector:
        """Distance beyond the bound, (runs,): positive where the condition holds.

        A run that does not reach its end is infinitely beyond, as is one that never settles. A run
        that has no other metric is infinitely far from it.

        Args:
            columns: Columns of the table of runs.
        """
        value = columns[self.metric]
        away = value - self.bound if self.above else self.bound - value
        fallback = np.inf if self.metric.split(".")[-1] == "settling" and self.above else -np.inf
        away = np.where(np.isnan(away), fallback, away)
        return np.where(columns["status"] != 0, np.inf, away)

    def missing(self, columns: Mapping[str, Vector]) -> int:
        """Number of complete runs that have no metric although they should have one."""
        if self.metric.split(".")[-1] in (NO_EVENT, "settling"):
            return 0
        return int(np.sum(np.isnan(columns[self.metric]) & (columns["status"] == 0)))


def known_metric(name: str, scenario: Scenario, where: str) -> str:
    """Check that a scenario has a metric; raises `InputError`."""
    metrics = metrics_of(scenario)
    if name not in metrics:
        raise InputError(f"{where}: found {name!r}, expected one of {', '.join(metrics)}")
    return name


def quantity(text: str, unit: str, where: str) -> float:
    """Parse a quantity in a unit of the dimension of an SI unit.

    Args:
        text: Number, with a unit or in SI.
        unit: SI unit of the dimension.
        where: Place for messages.

    Raises:
        InputError: The text is not a number of this dimension.
    """
    dimension = next((name for name, symbol in SI_UNIT.items() if symbol == unit), None)
    if dimension is not None:
        return parse_quantity(text, dimension, where)
    percent = text.endswith("%") and unit == "1"
    try:
        value = ascii_number(text.removesuffix("%") if percent else text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{where}: found {text!r}, expected a number in {unit}")
    return 0.01 * value if percent else value
