"""Friction feed-forward from the nominal model and an estimate of what it lacks."""

from dataclasses import dataclass, replace
from typing import Annotated

from gyrostat.control import EstimatingFeedForward
from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import GYRO, Context, Kind
from gyrostat.scenario.schema import positive, size

PULSE_SHARE = 0.2
"""Standard deviation of a tachometer that counts pulses, over the speed of one pulse."""
LEAST_NOISE, LEAST_RATE_NOISE = 1e-3, 1e-7
"""Smallest noise of tachometer and gyro that the compensator assumes, rad/s."""


@dataclass(frozen=True, eq=False)
class Estimating(Kind):
    """Friction feed-forward from the nominal friction model and an estimate of what it lacks.

    A filter for each wheel finds the friction beyond the model from gyro, tachometer and
    conservation of momentum (`gyrostat.control.EstimatingFeedForward`).
    """

    name = "estimating"
    needs = frozenset({GYRO})
    speed_sigma: Annotated[
        Scalar,
        size(
            "speed",
            0.0,
            "Standard deviation of a tachometer sample; 0: that of the nominal sensors, with a "
            "fifth of the speed of one pulse.",
        ),
    ]
    rate_sigma: Annotated[
        Scalar,
        size(
            "speed",
            0.0,
            "Standard deviation of each component of the measured rate; 0: that of the nominal "
            "sensors.",
        ),
    ]
    bandwidth: Annotated[
        Scalar,
        positive("rad/s", 0.6, "Bandwidth of the friction estimate of a wheel that turns."),
    ]
    gain: Annotated[
        Scalar, size("1/s", 1.0, "Gain by which the momentum lost to friction is returned.")
    ]
    band: Annotated[
        Scalar,
        positive(
            "1",
            3.0,
            "Speed at which the compensation is complete without needed torque, in standard "
            "deviations of the speed.",
        ),
    ]
    softness: Annotated[
        Scalar,
        positive(
            "1",
            0.6,
            "Needed torque over breakaway torque at which the compensation at rest is complete.",
        ),
    ]
    doubt: Annotated[
        Scalar,
        size(
            "1",
            0.5,
            "Standard deviation of the friction of a wheel whose direction is not known, over the "
            "breakaway torque.",
        ),
    ]
    largest: Annotated[
        Scalar, positive("1", 3.0, "Largest compensated friction torque over that of the model.")
    ]

    def make(self, context: Context) -> EstimatingFeedForward:
        """Compensator."""
        spacecraft, period = context.spacecraft, context.period
        assert spacecraft is not None
        assert period is not None
        sensors = {"wheel_sigma": 0.0, "rate_sigma": 0.0, "angle_walk": 0.0, **context.sensors}
        pulses = jnp.asarray(sensors["tachometer_pulses"])
        pulse = 2.0 * jnp.pi / (jnp.where(pulses > 0.0, pulses, jnp.inf) * period)
        older_sigma = jnp.max(sensors["wheel_sigma"] / jnp.asarray(spacecraft.wheels.inertia))
        speed_noise = jnp.sqrt(
            sensors["speed_sigma"] ** 2 + older_sigma**2 + (PULSE_SHARE * pulse) ** 2
        )
        rate_noise = jnp.sqrt(sensors["rate_sigma"] ** 2 + sensors["angle_walk"] ** 2 / period)
        speed_sigma, rate_sigma = self.speed_sigma, self.rate_sigma
        compensator = EstimatingFeedForward.tune(
            context.controller,
            spacecraft,
            speed_sigma=jnp.maximum(
                jnp.where(speed_sigma > 0.0, speed_sigma, speed_noise), LEAST_NOISE
            ),
            rate_sigma=jnp.maximum(
                jnp.where(rate_sigma > 0.0, rate_sigma, rate_noise), LEAST_RATE_NOISE
            ),
            period=period,
            bandwidth=self.bandwidth,
            delay=context.delay,
        )
        names = ("gain", "band", "softness", "doubt", "largest")
        return replace(compensator, **{name: getattr(self, name) for name in names})
