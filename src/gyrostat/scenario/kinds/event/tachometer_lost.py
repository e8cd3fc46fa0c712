"""Loss of a wheel's tachometer."""

from dataclasses import dataclass
from typing import Any

from gyrostat.scenario.event_kind import WheelFailure


@dataclass(frozen=True, eq=False)
class TachometerLost(WheelFailure):
    """The speed of `wheel` is no longer measured: the measurement keeps its last value."""

    name = "tachometer_lost"

    def effect(self) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"sensor_lost": True}
