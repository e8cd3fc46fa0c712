"""Bearing with more drag."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.event_kind import WheelFailure
from gyrostat.scenario.schema import size


@dataclass(frozen=True, eq=False)
class Drag(WheelFailure):
    """The viscous drag of the bearing of `wheel` increases; the controller is not notified."""

    name = "drag"
    added_viscous: Annotated[Scalar, size("viscous", None, "Viscous drag added to the bearing.")]
