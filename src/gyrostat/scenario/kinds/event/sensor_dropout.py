"""Missing samples."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.scenario.event_kind import SHARE, UNTIL, SensorFailure
from gyrostat.scenario.schema import Key


class SensorDropout(SensorFailure):
    """Samples of the measured field `sensor` are missing: the controller gets NaN."""

    name = "sensor_dropout"
    fault = "dropout"
    keys: ClassVar[Mapping[str, Key]] = {"until": UNTIL, "share": SHARE}
