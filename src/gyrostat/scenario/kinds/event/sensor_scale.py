"""Sensor with a wrong scale."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import UNTIL, SensorFailure
from gyrostat.scenario.schema import Key, Measured


@dataclass(frozen=True, eq=False)
class SensorScale(SensorFailure):
    """The measured field `sensor` is multiplied by `factor`; at -1 its sign is wrong."""

    name = "sensor_scale"
    fault = "scale"
    until: Annotated[Scalar, UNTIL]
    factor: Annotated[Scalar, Key("1", None, "Factor on the value.")]

    @classmethod
    def suits(cls, field: Measured) -> bool:
        """See `EventKind.suits`."""
        return field[1] is not None
