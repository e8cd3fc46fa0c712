"""Vibration mode."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Vector3
from gyrostat.scenario.appendage_kind import AppendageKind
from gyrostat.scenario.schema import vector


@dataclass(frozen=True, eq=False)
class Flexible(AppendageKind):
    """One vibration mode (`gyrostat.spacecraft.FlexibleModes`)."""

    name = "flexible"
    participation: Annotated[
        Vector3,
        vector(
            "√kg·m",
            "Angular momentum about the centre of mass per modal rate, body axes.",
            source="vibration",
        ),
    ]
    translation: Annotated[
        Vector3, vector("√kg", "Linear momentum per modal rate, body axes.", source="vibration")
    ]
