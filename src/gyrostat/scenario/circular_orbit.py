"""Keys of a circular orbit that a component has of its own."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import pi
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Kind
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import Key, positive, size
from gyrostat.spacecraft import CircularOrbit
from gyrostat.spacecraft.environment import EARTH, EARTH_RADIUS


@dataclass(frozen=True, eq=False)
class HasOrbit(Kind):
    """Component in a circular orbit of its own."""

    altitude: Annotated[
        Scalar, positive("length", None, "Altitude above the equatorial radius of the Earth.")
    ]
    inclination: Annotated[
        Scalar, size("angle", 0.0, "Inclination to the inertial x-y plane.", most=pi)
    ]
    ascending_node: Annotated[
        Scalar, Key("angle", 0.0, "Ascending node, from inertial x towards y.")
    ]
    latitude: Annotated[
        Scalar, Key("angle", 0.0, "Initial argument of latitude, from the ascending node.")
    ]

    def circular(self) -> CircularOrbit:
        """Orbit from the values of the keys."""
        rate = jnp.sqrt(EARTH / (EARTH_RADIUS + self.altitude) ** 3)
        names = ("inclination", "ascending_node", "latitude")
        return CircularOrbit(rate, **{name: getattr(self, name) for name in names})


@dataclass(frozen=True, eq=False)
class EitherOrbit(HasOrbit):
    """Component that follows the tables of [orbit], or a circular orbit of its own."""

    altitude: Annotated[
        Scalar,
        size(
            "length",
            0.0,
            "Altitude above the equatorial radius of the Earth, of a circular orbit; required "
            "without [orbit], and not allowed with it.",
        ),
    ]

    @classmethod
    def relations(cls, place: str, scenario: Scenario) -> Iterator[Relation]:
        """There is one orbit."""
        key = f"{place}.altitude"
        if scenario.orbit == "none":
            text = f"{key}: found none, expected it, or a section [orbit]"
            yield Relation((key,), text, lambda values: values[key] != 0.0)
        else:
            text = f"{key}: found {{{key}}} m beside [orbit], expected none"
            yield Relation((key,), text, lambda values: values[key] == 0.0)
