"""Missing samples."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import SHARE, UNTIL, SensorFailure


@dataclass(frozen=True, eq=False)
class SensorDropout(SensorFailure):
    """Samples of the measured field `sensor` are missing: the controller gets NaN."""

    name = "sensor_dropout"
    fault = "dropout"
    until: Annotated[Scalar, UNTIL]
    share: Annotated[Scalar, SHARE]
