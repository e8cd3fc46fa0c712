"""Contracts of user-defined parts as protocols, which a type checker checks.

`part: Controller = EarthPointer(kp=0.02)` lets a type checker compare a class with its contract. A
part does not inherit from its protocol. Examples: docs/your_own_parts.md, your_own_plant_parts.md.
"""

from typing import Any, Protocol

from gyrostat.simulation.loop import Controller
from gyrostat.spacecraft import Actuator, ActuatorWithState, AddedSensor, Change, TorqueModel

__all__ = [
    "Actuator",
    "ActuatorWithState",
    "AddedSensor",
    "Change",
    "Compensator",
    "Controller",
    "Estimator",
    "Predicting",
    "TorqueModel",
]


class Compensator(Controller, Protocol):
    """Protocol of a compensator: a controller that changes the command of another one.

    Attributes:
        controller: Wrapped controller, given by the scenario.
    """

    controller: Any


class Estimator(Controller, Protocol):
    """Protocol of an estimator: a controller that gives another measurement to the wrapped one.

    Attributes:
        controller: Wrapped controller, given by the scenario.
    """

    controller: Any


class Predicting(Protocol):
    """Protocol of an optional method of controllers, compensators and estimators."""

    def predicted(self, memory: Any, measurement: Any, command: Any) -> Any:
        """Memory one control period later, after a sample that the guard rejected.

        Without this method the memory is unchanged.

        Args:
            memory: Memory from the last sample.
            measurement: Last accepted measurement.
            command: Command that is sent.
        """
        ...
