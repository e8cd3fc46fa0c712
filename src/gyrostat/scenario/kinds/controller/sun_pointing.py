"""Sun pointing by wheels."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control.attitude.sun_pointing import SunPointing
from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import part_named
from gyrostat.scenario.controller_kind import IGNORED, Beginning, ControllerKind, DesignCase
from gyrostat.scenario.schema import direction, positive, vector


@dataclass(frozen=True, eq=False)
class SunPointingKind(ControllerKind):
    """Sun pointing of a body axis by wheels (`gyrostat.control.SunPointing`).

    It needs a `[[sensor]]` named `sun_sensor` or `coarse_sun_sensors`. While the Sun is not seen,
    the rate is damped only.
    """

    name = "sun_pointing"
    losses = IGNORED
    follows = False
    needs = frozenset({part_named("sensor", "sun_sensor", "coarse_sun_sensors")})
    axis: Annotated[Vector3, direction("Body axis, of any length.")]
    turn_gain: Annotated[Scalar, positive("1/s", 0.05, "Commanded rate per angle to the Sun.")]
    rate_gain: Annotated[Scalar, positive("1/s", 0.2, "Gain of the rate loop.")]
    largest_rate: Annotated[Scalar, positive("speed", 0.02, "Largest commanded rate.")]
    search_rate: Annotated[Vector3, vector("speed", "Commanded rate while the Sun is not seen.")]

    @classmethod
    def plan(cls, case: DesignCase) -> SunPointing:
        """See `ControllerKind.plan`."""
        return SunPointing(case.spacecraft)

    def controller(self, design: SunPointing, beginning: Beginning) -> SunPointing:
        """See `ControllerKind.controller`."""
        return replace(design, **self.options())
