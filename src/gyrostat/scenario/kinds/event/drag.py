"""Bearing with more drag."""

from collections.abc import Mapping
from typing import ClassVar

from gyrostat.scenario.event_kind import WheelFailure
from gyrostat.scenario.schema import Key, size


class Drag(WheelFailure):
    """The viscous drag of the bearing of `wheel` increases; the controller is not notified."""

    name = "drag"
    keys: ClassVar[Mapping[str, Key]] = {
        "added_viscous": size("viscous", None, "Viscous drag added to the bearing.")
    }
