"""Names, units and meanings of the metrics of a scenario."""

from collections.abc import Collection
from typing import NamedTuple

from gyrostat.campaigns.metrics.schema import (
    BUDGET,
    GAINED,
    PERCENTILE,
    RESULTS,
    WINDOW_PERCENTILE,
    WINDOW_RESULTS,
)
from gyrostat.campaigns.scenario import Scenario, Window


class Metric(NamedTuple):
    """Metric of a run: a column of the table of runs.

    Attributes:
        unit: SI unit.
        meaning: One sentence.
        window: Name of its window; None for the whole run.
    """

    unit: str
    meaning: str
    window: str | None = None


def metrics_of(scenario: Scenario) -> dict[str, Metric]:
    """Every metric of a scenario, by name and in the order of the table of runs."""
    percentiles = [percentile_name(percent) for percent in scenario.percentiles]
    found = {name: Metric(*PERCENTILE) for name in percentiles}
    found |= {name: Metric(*entry) for name, entry in RESULTS.items()}
    for window in scenario.windows:
        prefix = f"window.{window.name}."
        keys = {key.removeprefix(prefix) for key in scenario.values if key.startswith(prefix)}
        own = {name: Metric(*WINDOW_PERCENTILE, window.name) for name in percentiles}
        own |= window_metrics(window, keys, scenario.wheels, scenario.boresight)
        found |= {f"{window.name}.{name}": metric for name, metric in own.items()}
    found |= {each.metric: Metric(each.unit, each.meaning) for each in scenario.requirements}
    return found | _own_metrics(scenario) | _budget(scenario)


def _budget(scenario: Scenario) -> dict[str, Metric]:
    """Metrics of the momentum budget."""
    if not scenario.budget:
        return {}
    names = ["constant"]
    names += ["gravity_gradient", "harmonic"] if scenario.environment == "orbit" else []
    names += [part.name for part in scenario.parts if part.section == "environment.torque"]
    names += [f"actuator.{part.name}" for part in scenario.parts if part.section == "actuator"]
    return {f"{GAINED}.{name}": Metric(*BUDGET) for name in names}


def _own_metrics(scenario: Scenario) -> dict[str, Metric]:
    parts = [part for part in scenario.parts if part.section == "metric"]
    if not parts:
        return {}
    from gyrostat.campaigns.kinds import component  # imports JAX, which takes long

    made = {part.name: component(part.section, part.kind, scenario.sources) for part in parts}
    return {name: Metric(own.unit, own.meaning) for name, own in made.items()}


def percentile_name(percent: float) -> str:
    """Name of a percentile of the pointing error."""
    return f"error_p{percent:g}"


def window_metrics(
    window: Window,
    keys: Collection[str],
    wheels: Collection[str],
    boresight: tuple[float, ...] | None,
) -> dict[str, Metric]:
    """Metrics of a window except percentiles, without the name of the window.

    Args:
        window: Window.
        keys: Keys of its numbers.
        wheels: Names of the wheels.
        boresight: Boresight of the window, or that of the scenario.
    """
    asked = {"", *keys}
    asked |= {"boresight"} if boresight is not None else set()
    asked |= {"propellant"} if window.propellant is not None else set()
    found = {
        name: Metric(unit, meaning, window.name)
        for name, (unit, key, meaning) in WINDOW_RESULTS.items()
        if key in asked
    }
    if "dwell" in found:
        each = "Fraction of time in which the speed of this wheel is in the band."
        found |= {f"dwell.{wheel}": Metric("1", each, window.name) for wheel in wheels}
    return found
