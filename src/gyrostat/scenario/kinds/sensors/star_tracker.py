"""Star tracker with and without a gyro."""

from dataclasses import dataclass, fields, replace
from math import inf
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import GYRO, STAR_TRACKER, Context
from gyrostat.scenario.schema import Key, positive, size, vector
from gyrostat.scenario.sensors_kind import SensorsKind
from gyrostat.spacecraft import RateGyro, SpacecraftSensor, StarTracker, TrackerGyroSensors


@dataclass(frozen=True, eq=False)
class StarTrackerKind(SensorsKind):
    """Star tracker and tachometers, without a gyro, for the estimator `momentum`.

    See `gyrostat.spacecraft.TrackerGyroSensors`.
    """

    name = "star_tracker"
    provides = frozenset({STAR_TRACKER})
    estimator = "momentum"
    measured = ("attitude", "wheel_speed")
    attitude_sigma: Annotated[
        Scalar,
        positive(
            "angle",
            None,
            "Standard deviation of the star tracker about each body axis.",
            source="star tracker noise",
        ),
    ]
    tracker_periods: Annotated[
        Scalar,
        Key(
            "1",
            1.0,
            "Control periods between star tracker samples, rounded to a whole number.",
            least=1.0,
        ),
    ]

    def make(self, context: Context) -> TrackerGyroSensors:
        """Sensors."""
        return TrackerGyroSensors(
            SpacecraftSensor(context.plant, tachometer=self.tachometer(context)),
            StarTracker(self.attitude_sigma, jnp.round(self.tracker_periods)),
        )


@dataclass(frozen=True, eq=False)
class StarTrackerGyro(StarTrackerKind):
    """Star tracker, gyro and tachometers, for the estimator `kalman`.

    See `gyrostat.spacecraft.TrackerGyroSensors`. The gyro gives the integral of the body rate over
    the period (`gyrostat.spacecraft.RateGyro`).
    """

    name = "star_tracker_gyro"
    provides = frozenset({STAR_TRACKER, GYRO})
    estimator = "kalman"
    measured = SensorsKind.measured
    angle_walk: Annotated[
        Scalar,
        positive("angle_random_walk", None, "Angle random walk of the gyro.", source="gyro noise"),
    ]
    bias_walk: Annotated[
        Scalar,
        size("rate_random_walk", 0.0, "Random walk of the gyro bias.", source="gyro bias walk"),
    ]
    bias: Annotated[Vector3, vector("speed", "Initial bias of the gyro.", source="gyro bias")]
    scale_factor: Annotated[
        Vector3,
        Key(
            "1",
            0.0,
            "Scale factor error of each gyro axis.",
            least=-1.0,
            positive=True,
            shape=(3,),
            source="gyro scale factor",
        ),
    ]
    misalignment: Annotated[
        Vector3,
        vector("angle", "Rotation vector from body to gyro axes.", source="gyro misalignment"),
    ]
    rate_limit: Annotated[Scalar, positive("speed", inf, "Largest rate that a gyro axis measures.")]
    coning_compensation: Annotated[
        Scalar,
        size("1", 0.0, "Fraction of the coning for which the gyro compensates.", most=1.0),
    ]

    def make(self, context: Context) -> TrackerGyroSensors:
        """Sensors."""
        gyro = RateGyro(**{field.name: getattr(self, field.name) for field in fields(RateGyro)})
        return replace(super().make(context), gyro=gyro)
