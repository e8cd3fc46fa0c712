"""Motor that ignores commands."""

from dataclasses import dataclass
from typing import Annotated, Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import DETECTED, WheelFailure
from gyrostat.scenario.schema import Key


@dataclass(frozen=True, eq=False)
class StuckTorque(WheelFailure):
    """The motor of `wheel` gives a constant torque and ignores commands."""

    name = "stuck_torque"
    loses_wheel = True
    detected_after: Annotated[Scalar, DETECTED]
    torque: Annotated[Scalar, Key("torque", None, "Constant motor torque.")]

    def effect(self) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0, "stuck_torque": self.torque}
