"""Sun pointing as a reference."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import Pointing, to_sun
from gyrostat.core.arrays import Vector3
from gyrostat.scenario.component import ORBIT
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind, axes_apart
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import direction


@dataclass(frozen=True, eq=False)
class Sun(ProfileKind):
    """Sun pointing along [orbit] (`gyrostat.control.guidance.Pointing`)."""

    name = "sun"
    needs = frozenset({ORBIT})
    to_sun: Annotated[Vector3, direction("Body axis that points to the Sun.", (1.0, 0.0, 0.0))]
    normal: Annotated[
        Vector3,
        direction(
            "Body axis whose part across `to_sun` points along the orbit normal.",
            (0.0, 1.0, 0.0),
        ),
    ]

    @classmethod
    def relations(cls, place: str, scenario: Scenario) -> Iterator[Relation]:
        """See `Kind.relations`: the axes are not parallel."""
        yield axes_apart(place, ("to_sun", "normal"))

    def profile(self, planned: PlannedReference, place: str) -> Pointing:
        """See `ProfileKind.profile`."""
        return planned.pointing(to_sun, self.to_sun, self.normal)
