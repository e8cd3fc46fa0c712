"""Seized rotor."""

from collections.abc import Mapping
from typing import Any, ClassVar

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import DETECTED, WheelFailure
from gyrostat.scenario.schema import Key


class Seized(WheelFailure):
    """The rotor of `wheel` stops instantly; its momentum is transferred to the body."""

    name = "seized"
    keys: ClassVar[Mapping[str, Key]] = {"detected_after": DETECTED}
    loses_wheel = True
    stops_rotor = True

    @classmethod
    def effect(cls, values: Mapping[str, Scalar]) -> dict[str, Any]:
        """See `WheelFailure.effect`."""
        return {"torque_share": 0.0}
