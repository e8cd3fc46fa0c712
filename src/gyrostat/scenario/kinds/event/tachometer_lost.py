"""Loss of a wheel's tachometer."""

from collections.abc import Mapping
from typing import Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import WheelFailure


class TachometerLost(WheelFailure):
    """The speed of `wheel` is no longer measured: the measurement keeps its last value."""

    name = "tachometer_lost"

    @classmethod
    def effect(cls, values: Mapping[str, Scalar]) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"sensor_lost": True}
