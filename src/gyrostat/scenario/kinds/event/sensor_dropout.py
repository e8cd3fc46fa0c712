"""Missing samples."""

from collections.abc import Mapping
from math import inf
from typing import ClassVar

from gyrostat.scenario.event_kind import SensorFailure
from gyrostat.scenario.schema import Key, size


class SensorDropout(SensorFailure):
    """Samples of the measured field `sensor` are missing: the controller gets NaN."""

    name = "sensor_dropout"
    fault = "dropout"
    keys: ClassVar[Mapping[str, Key]] = {
        "until": size("time", inf, "End of the fault."),
        "share": size("1", 1.0, "Probability that a sample is affected.", most=1.0),
    }
