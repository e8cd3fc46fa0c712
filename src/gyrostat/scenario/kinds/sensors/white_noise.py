"""Attitude and rate with white noise."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar
from gyrostat.scenario.component import GYRO, Context
from gyrostat.scenario.schema import size
from gyrostat.scenario.sensors_kind import SensorsKind
from gyrostat.spacecraft import SpacecraftSensor


@dataclass(frozen=True, eq=False)
class WhiteNoise(SensorsKind):
    """Attitude and rate with white noise, wheel speeds from tachometers.

    See `gyrostat.spacecraft.SpacecraftSensor` and `gyrostat.wheel.WheelTachometer`.
    """

    name = "white_noise"
    provides = frozenset({GYRO})
    estimator = "none"
    attitude_sigma: Annotated[
        Scalar,
        size(
            "angle",
            0.0,
            "Standard deviation of the attitude about each body axis.",
            source="attitude noise",
        ),
    ]
    rate_sigma: Annotated[
        Scalar,
        size(
            "speed",
            0.0,
            "Standard deviation of each component of the body rate.",
            source="rate noise",
        ),
    ]

    def make(self, context: Context) -> SpacecraftSensor:
        """Sensors."""
        return SpacecraftSensor(
            context.plant,
            self.attitude_sigma,
            self.rate_sigma,
            tachometer=self.tachometer(context),
        )
