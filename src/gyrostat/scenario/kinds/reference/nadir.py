"""Nadir pointing."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from gyrostat.control.guidance import Nadir, Profile, to_earth
from gyrostat.core.arrays import Vector3
from gyrostat.scenario.circular_orbit import EitherOrbit, HasOrbit
from gyrostat.scenario.reference_kind import PlannedReference, ProfileKind, axes_apart
from gyrostat.scenario.relation import Relation
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import direction


@dataclass(frozen=True, eq=False)
class NadirKind(EitherOrbit, ProfileKind):
    """Nadir pointing along [orbit], or on a circular orbit.

    See `gyrostat.control.guidance.Pointing` and `gyrostat.control.guidance.Nadir`. Elements that
    are not given are those of the environment `orbit`.
    """

    name = "nadir"
    to_earth: Annotated[Vector3, direction("Body axis that points to the Earth.")]
    along: Annotated[
        Vector3,
        direction(
            "Body axis whose part across `to_earth` points along the velocity.",
            (1.0, 0.0, 0.0),
        ),
    ]

    @classmethod
    def row(cls, row: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
        """See `Kind.row`: the elements of the environment `orbit`."""
        keys = HasOrbit.keys()
        full_keys = {name: f"environment.{name}" for name in keys}
        defaults = {name: values[key] for name, key in full_keys.items() if key in values}
        return {**defaults, **row}

    @classmethod
    def relations(cls, place: str, scenario: Scenario) -> Iterator[Relation]:
        """See `Kind.relations`: the axes are not parallel."""
        yield from super().relations(place, scenario)
        yield axes_apart(place, ("to_earth", "along"))

    def profile(self, planned: PlannedReference, place: str) -> Profile:
        """See `ProfileKind.profile`."""
        axes = self.to_earth, self.along
        if planned.orbit is None:
            return Nadir.pointing(self.circular(), *axes)
        return planned.pointing(to_earth, *axes)
