"""Kalman filter for attitude and gyro bias."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control import OutputFeedback
from gyrostat.core.arrays import Scalar
from gyrostat.estimation import AttitudeFilter
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive


@dataclass(frozen=True, eq=False)
class Kalman(Kind):
    """Multiplicative Kalman filter for attitude and gyro bias.

    See `gyrostat.estimation.AttitudeFilter`. It assumes the nominal sensor noise.
    """

    name = "kalman"
    bias_sigma: Annotated[
        Scalar, positive("speed", 1e-4, "Initial standard deviation of the gyro bias.")
    ]

    def make(self, context: Context) -> OutputFeedback:
        """Controller with the estimator."""
        names = ("attitude_sigma", "angle_walk", "bias_walk")
        noise = {name: context.sensors[name] for name in names}
        # the filter corrects the remaining coning
        coning = 1.0 - context.sensors["coning_compensation"]
        estimator = AttitudeFilter(**noise, **self.options(), coning=coning)
        return OutputFeedback(estimator, context.controller)
