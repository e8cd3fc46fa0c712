"""Orbit that is circular at the epoch."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.orbit_kind import ASCENDING_NODE, INCLINATION, OrbitKind
from gyrostat.scenario.schema import Key, positive
from gyrostat.spacecraft.orbit.elements import CircularElements


@dataclass(frozen=True, eq=False)
class Circular(OrbitKind):
    """Orbit that is circular at the epoch, with the oblateness J2 of the Earth."""

    name = "circular"
    texts = ("epoch",)
    altitude: Annotated[Scalar, positive("length", None, "Altitude above the equatorial radius.")]
    inclination: Annotated[Scalar, INCLINATION]
    ascending_node: Annotated[Scalar, ASCENDING_NODE]
    latitude: Annotated[Scalar, Key("angle", 0.0, "Argument of latitude, from the ascending node.")]

    def elements(self, texts: Mapping[str, str]) -> CircularElements:
        """See `OrbitKind.elements`."""
        names = ("altitude", "inclination", "ascending_node", "latitude")
        return CircularElements(**self.named(*names))
