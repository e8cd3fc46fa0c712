"""Band of wheel speeds to avoid."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.core.errors import InputError
from gyrostat.scenario.component import Kind
from gyrostat.scenario.scenario import Scenario
from gyrostat.scenario.schema import positive, size


@dataclass(frozen=True, eq=False)
class Speeds(Kind):
    """Wheel speeds of either sign that the null-space control of a `wheel_array` avoids."""

    name = "speeds"
    above: Annotated[Scalar, size("speed", 0.0, "Lower end of the band.")]
    below: Annotated[Scalar, positive("speed", None, "Upper end of the band.")]

    @classmethod
    def check(cls, place: str, scenario: Scenario) -> None:
        """Check that the band has a width."""
        low, high = (scenario.values[f"{place}.{end}"] for end in ("above", "below"))
        if low >= high:
            section, _, name = place.rpartition(".")
            raise InputError(
                f"key {section}[{name}].below: found {high:g} rad/s, expected more than above, "
                f"{low:g} rad/s"
            )
