"""What a scenario is: values, components, events, dispersions, metrics and requirements."""

from gyrostat.scenario.requirement import Requirement
from gyrostat.scenario.scenario import Dispersion, Event, Scenario, Window
from gyrostat.scenario.schema import Key

__all__ = ["Dispersion", "Event", "Key", "Requirement", "Scenario", "Window"]
