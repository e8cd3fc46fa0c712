"""Sensor that repeats its last value."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import UNTIL, SensorFailure


@dataclass(frozen=True, eq=False)
class SensorStuck(SensorFailure):
    """The measured field `sensor` keeps its last value."""

    name = "sensor_stuck"
    fault = "stuck"
    until: Annotated[Scalar, UNTIL]
