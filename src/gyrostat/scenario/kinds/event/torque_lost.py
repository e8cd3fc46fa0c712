"""Loss of a motor's torque."""

from dataclasses import dataclass
from typing import Annotated, Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import ADDED_DRAG, DETECTED, WheelFailure


@dataclass(frozen=True, eq=False)
class TorqueLost(WheelFailure):
    """The motor of `wheel` loses its torque; friction slows the rotor down."""

    name = "torque_lost"
    loses_wheel = True
    detected_after: Annotated[Scalar, DETECTED]
    added_viscous: Annotated[Scalar, ADDED_DRAG]

    def effect(self) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0}
