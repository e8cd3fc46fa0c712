"""Seized rotor."""

from dataclasses import dataclass
from typing import Annotated, Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import DETECTED, WheelFailure


@dataclass(frozen=True, eq=False)
class Seized(WheelFailure):
    """The rotor of `wheel` stops instantly; its momentum is transferred to the body."""

    name = "seized"
    loses_wheel = True
    stops_rotor = True
    detected_after: Annotated[Scalar, DETECTED]

    def effect(self) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0}
