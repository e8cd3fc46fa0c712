"""Kalman filter for attitude and total momentum, without a gyro."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.control import OutputFeedback
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.estimation import MomentumAttitudeFilter
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import positive, size
from gyrostat.scenario.sensors_kind import speed_sigma_of


@dataclass(frozen=True, eq=False)
class Momentum(Kind):
    """Kalman filter for attitude, total momentum and rotor inertias, without a gyro.

    The body rate follows from the total momentum and the wheel speeds
    (`gyrostat.estimation.MomentumAttitudeFilter`). It assumes the nominal sensor noise. It needs
    tachometers that work.
    """

    name = "momentum"
    bandwidth: Annotated[Scalar, positive("rad/s", 0.2, "Bandwidth of the filter.")]
    rotor_sigma: Annotated[
        Scalar,
        size(
            "1",
            0.1,
            "Relative standard deviation of the rotor inertias over the body inertia; 0: those of "
            "the model are trusted.",
        ),
    ]
    rate_sigma: Annotated[
        Scalar,
        positive(
            "speed", 0.01, "Standard deviation of the body rate at the start about each axis."
        ),
    ]

    def make(self, context: Context) -> OutputFeedback:
        """Controller with the estimator."""
        spacecraft, sensors = context.spacecraft, context.sensors
        assert spacecraft is not None
        estimator = MomentumAttitudeFilter(
            spacecraft,
            sensors["attitude_sigma"],
            jnp.round(sensors["tracker_periods"]),
            speed_sigma_of(sensors["speed_sigma"], sensors["wheel_sigma"], spacecraft),
            **self.options(),
        )
        return OutputFeedback(estimator, context.controller)
