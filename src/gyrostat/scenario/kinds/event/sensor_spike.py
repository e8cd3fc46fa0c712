"""Samples with an offset."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import SHARE, UNTIL, SensorFailure
from gyrostat.scenario.schema import Key, Measured

if TYPE_CHECKING:
    from gyrostat.wheel.friction_laws import Law


@dataclass(frozen=True, eq=False)
class SensorSpike(SensorFailure):
    """`magnitude` is added to samples of the measured field `sensor`, in the unit of the field.

    With the default `share` of 1 it is a step of the bias.
    """

    name = "sensor_spike"
    fault = "spike"
    until: Annotated[Scalar, UNTIL]
    share: Annotated[Scalar, SHARE]

    @classmethod
    def keys_of(
        cls, law: "Law", sensor: str | None, fields: Mapping[str, Measured]
    ) -> dict[str, Key]:
        """See `EventKind.keys_of`."""
        keys = super().keys_of(law, sensor, fields)
        if sensor is not None:
            keys["magnitude"] = Key(fields[sensor][0], None, "Offset added to the value.")
        return keys
