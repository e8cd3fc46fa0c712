"""Sensor whose offset grows."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import UNTIL, SensorFailure
from gyrostat.scenario.schema import Key, Measured

if TYPE_CHECKING:
    from gyrostat.wheel.friction_laws import Law


@dataclass(frozen=True, eq=False)
class SensorDrift(SensorFailure):
    """An offset of the measured field `sensor` grows from zero by `slope` a second.

    The slope is in the unit of the field per second. At `until` the offset is gone.
    """

    name = "sensor_drift"
    fault = "drift"
    until: Annotated[Scalar, UNTIL]

    @classmethod
    def suits(cls, field: Measured) -> bool:
        """See `EventKind.suits`."""
        return field[1] is not None

    @classmethod
    def keys_of(
        cls, law: "Law", sensor: str | None, fields: Mapping[str, Measured]
    ) -> dict[str, Key]:
        """See `EventKind.keys_of`."""
        keys = super().keys_of(law, sensor, fields)
        unit = None if sensor is None else fields[sensor][1]
        if unit is not None:
            keys["slope"] = Key(unit, None, "Growth of the offset.")
        return keys
