"""Orbit from osculating Keplerian elements."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.orbit_kind import ASCENDING_NODE, INCLINATION, OrbitKind
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.spacecraft.orbit.elements import KeplerElements


@dataclass(frozen=True, eq=False)
class Kepler(OrbitKind):
    """Orbit from osculating Keplerian elements at the epoch, with the oblateness J2."""

    name = "kepler"
    texts = ("epoch",)
    semi_major_axis: Annotated[Scalar, positive("length", None, "Semi-major axis.")]
    eccentricity: Annotated[Scalar, size("1", 0.0, "Eccentricity, below 1.", most=0.99)]
    inclination: Annotated[Scalar, INCLINATION]
    ascending_node: Annotated[Scalar, ASCENDING_NODE]
    perigee: Annotated[Scalar, Key("angle", 0.0, "Argument of perigee.")]
    true_anomaly: Annotated[Scalar, Key("angle", 0.0, "True anomaly.")]

    def elements(self, texts: Mapping[str, str]) -> KeplerElements:
        """See `OrbitKind.elements`."""
        shape = ("semi_major_axis", "eccentricity", "perigee", "true_anomaly")
        return KeplerElements(**self.named(*shape, "inclination", "ascending_node"))
