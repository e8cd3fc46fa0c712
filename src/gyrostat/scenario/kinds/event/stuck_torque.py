"""Motor that ignores commands."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import DETECTED, WheelFailure
from gyrostat.scenario.schema import Key


class StuckTorque(WheelFailure):
    """The motor of `wheel` gives a constant torque and ignores commands."""

    name = "stuck_torque"
    keys: ClassVar[Mapping[str, Key]] = {
        "detected_after": DETECTED,
        "torque": Key("torque", None, "Constant motor torque."),
    }
    loses_wheel = True

    @classmethod
    def effect(cls, values: Mapping[str, Scalar]) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0, "stuck_torque": values["torque"]}
