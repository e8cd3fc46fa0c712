"""Sensor that repeats its last value."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.scenario.event_kind import UNTIL, SensorFailure
from gyrostat.scenario.schema import Key


class SensorStuck(SensorFailure):
    """The measured field `sensor` keeps its last value."""

    name = "sensor_stuck"
    fault = "stuck"
    keys: ClassVar[Mapping[str, Key]] = {"until": UNTIL}
