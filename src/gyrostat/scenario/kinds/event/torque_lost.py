"""Loss of a motor's torque."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import ADDED_DRAG, DETECTED, WheelFailure
from gyrostat.scenario.schema import Key


class TorqueLost(WheelFailure):
    """The motor of `wheel` loses its torque; friction slows the rotor down."""

    name = "torque_lost"
    keys: ClassVar[Mapping[str, Key]] = {"detected_after": DETECTED, "added_viscous": ADDED_DRAG}
    loses_wheel = True

    @classmethod
    def effect(cls, values: Mapping[str, Scalar]) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0}
