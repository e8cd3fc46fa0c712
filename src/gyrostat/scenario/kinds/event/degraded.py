"""Motor with less torque."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import ADDED_DRAG, WheelFailure
from gyrostat.scenario.schema import Key, size


class Degraded(WheelFailure):
    """The motor of `wheel` gives a fraction of the commanded torque.

    The controller is not notified.
    """

    name = "degraded"
    keys: ClassVar[Mapping[str, Key]] = {
        "torque_share": size("1", None, "Remaining fraction of torque.", most=1.0),
        "added_viscous": ADDED_DRAG,
    }

    @classmethod
    def effect(cls, values: Mapping[str, Scalar]) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": values["torque_share"]}
