"""Panel on a hinge."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.appendage_kind import AppendageKind
from gyrostat.scenario.scenario import INERTIA
from gyrostat.scenario.schema import Key, direction, positive, vector


@dataclass(frozen=True, eq=False)
class HingedPanel(AppendageKind):
    """Rigid panel on a hinge with a spring (`gyrostat.spacecraft.hinged_panel`)."""

    name = "hinged_panel"
    mass: Annotated[Scalar, positive("mass", None, "Mass of the panel.", source="vibration")]
    hinge: Annotated[Vector3, vector("length", "Position of the hinge, body axes.")]
    centre: Annotated[Vector3, vector("length", "Centre of mass of the panel, body axes.")]
    axis: Annotated[Vector3, direction("Direction of the hinge line, of any length.", 0.0)]

    @classmethod
    def keys(cls) -> dict[str, Key]:
        """See `Kind.keys`; with the components of the inertia."""
        inertia = Key("inertia", None, "Inertia about its centre of mass.", source="vibration")
        return super().keys() | {f"inertia.{end}": inertia for end in INERTIA}
