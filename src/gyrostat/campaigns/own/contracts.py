"""Earlier place of `gyrostat.scenario.user.contracts`, so that older files still find it."""

from gyrostat.scenario.user.contracts import (
    Actuator,
    AddedSensor,
    Change,
    Compensator,
    Controller,
    Estimator,
    Predicting,
    TorqueModel,
)

__all__ = [
    "Actuator",
    "AddedSensor",
    "Change",
    "Compensator",
    "Controller",
    "Estimator",
    "Predicting",
    "TorqueModel",
]
