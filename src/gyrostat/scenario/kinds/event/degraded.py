"""Motor with less torque."""

from dataclasses import dataclass
from typing import Annotated, Any

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import ADDED_DRAG, WheelFailure
from gyrostat.scenario.schema import size


@dataclass(frozen=True, eq=False)
class Degraded(WheelFailure):
    """The motor of `wheel` gives a fraction of the commanded torque.

    The controller is not notified.
    """

    name = "degraded"
    torque_share: Annotated[Scalar, size("1", None, "Remaining fraction of torque.", most=1.0)]
    added_viscous: Annotated[Scalar, ADDED_DRAG]

    def effect(self) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": self.torque_share}
