"""Ground station."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control.guidance import StationView
from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import ORBIT, Context, Kind
from gyrostat.scenario.schema import Key, between_poles


@dataclass(frozen=True, eq=False)
class GroundStation(Kind):
    """Ground station, whose passes `check` lists and modes can wait for.

    See `gyrostat.control.guidance.StationView`.
    """

    name = "ground"
    needs = frozenset({ORBIT})
    latitude: Annotated[Scalar, between_poles("Geodetic latitude (WGS 84).")]
    longitude: Annotated[Scalar, Key("angle", None, "Longitude, to the east.")]
    height: Annotated[Scalar, Key("length", 0.0, "Height above the ellipsoid.")]
    least_elevation: Annotated[
        Scalar, between_poles("Elevation at which a pass begins and ends.", 0.0)
    ]

    def make(self, context: Context) -> StationView:
        """See `Kind.make`: the view from the station."""
        assert context.orbit is not None  # it is needed
        return StationView(context.orbit, **self.options())
