"""Head of a star tracker."""

from dataclasses import dataclass
from math import inf
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import ORBIT, STAR_TRACKER, Context, Kind
from gyrostat.scenario.schema import Key, direction, positive, size, vector
from gyrostat.spacecraft.sensors.star_tracker_heads import FIELD_LENGTH, StarTrackerHead


@dataclass(frozen=True, eq=False)
class Head(Kind):
    """Head of the star tracker of the sensors `star_tracker_gyro` or `star_tracker`.

    See `gyrostat.spacecraft.StarTrackerHead`.
    """

    name = "head"
    needs = frozenset({ORBIT, STAR_TRACKER})
    across_sigma: Annotated[
        Scalar,
        positive(
            "angle",
            None,
            "Standard deviation about each axis across the boresight.",
            source="noise",
        ),
    ]
    about_sigma: Annotated[
        Scalar, positive("angle", None, "Standard deviation about the boresight.", source="noise")
    ]
    boresight: Annotated[Vector3, direction("Boresight in body axes, of any length.")]
    misalignment: Annotated[
        Vector3,
        vector("angle", "Constant rotation of the measured attitude.", source="misalignment"),
    ]
    sun_exclusion: Annotated[
        Scalar, size("angle", 0.0, "Smallest angle between boresight and Sun.")
    ]
    earth_exclusion: Annotated[
        Scalar, size("angle", 0.0, "Smallest angle between boresight and limb of the Earth.")
    ]
    moon_exclusion: Annotated[
        Scalar, size("angle", 0.0, "Smallest angle between boresight and centre of the Moon.")
    ]
    rate_limit: Annotated[Scalar, positive("speed", inf, "Largest body rate.")]
    doubling_rate: Annotated[
        Scalar, positive("speed", inf, "Body rate at which the standard deviations have doubled.")
    ]
    delay: Annotated[
        Scalar,
        size(
            "time", 0.0, "Time between exposure and time tag that is not corrected.", source="delay"
        ),
    ]
    orbit_error: Annotated[
        Vector3,
        vector(
            "angle",
            "Amplitude of an error once per orbit, rotation vector in body axes.",
            source="orbit error",
        ),
    ]
    orbit_phase: Annotated[Scalar, Key("angle", 0.0, "Phase of this error at time 0.")]
    field_error: Annotated[
        Scalar,
        size(
            "angle",
            0.0,
            "Standard deviation across the boresight of the error that changes as the stars move "
            "over the field of view.",
            source="field of view error",
        ),
    ]
    field_length: Annotated[
        Scalar,
        positive(
            "angle", FIELD_LENGTH, "Rotation of the body over which this error is correlated."
        ),
    ]

    def make(self, context: Context) -> StarTrackerHead:
        """Head."""
        assert context.orbit is not None
        options = self.options()
        return StarTrackerHead(
            context.orbit, options.pop("across_sigma"), options.pop("about_sigma"), **options
        )
