"""Band of wheel speeds to avoid."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import Kind
from gyrostat.scenario.relation import Relation, less
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import positive, size


@dataclass(frozen=True, eq=False)
class Speeds(Kind):
    """Wheel speeds of either sign that the null-space control of a `wheel_array` avoids."""

    name = "speeds"
    above: Annotated[Scalar, size("speed", 0.0, "Lower end of the band.")]
    below: Annotated[Scalar, positive("speed", None, "Upper end of the band.")]

    @classmethod
    def relations(cls, place: str, scenario: Scenario) -> Iterator[Relation]:
        """The band has a width."""
        low, high = (f"{place}.{end}" for end in ("above", "below"))
        section, _, name = place.rpartition(".")
        yield less(
            low,
            high,
            f"{section}[{name}].below: found {{{high}}} rad/s, expected more than above, "
            f"{{{low}}} rad/s",
        )
