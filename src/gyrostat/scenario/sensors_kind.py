"""Base of the sensors that a scenario can name, whose classes are in kinds/sensors."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from gyrostat.core.arrays import PerWheel, Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import Context, Kind
from gyrostat.scenario.schema import MEASURED, Key, size
from gyrostat.spacecraft import Spacecraft
from gyrostat.wheel import WheelTachometer


def speed_sigma_of(speed_sigma: Scalar, wheel_sigma: Scalar, known: Spacecraft) -> PerWheel:
    """Standard deviation of the tachometers, (wheels,), rad/s.

    Args:
        speed_sigma: That of a tachometer sample, rad/s.
        wheel_sigma: Its older form, N·m·s, of the momentum with the nominal rotor inertia.
        known: Nominal spacecraft.
    """
    return jnp.hypot(speed_sigma, wheel_sigma / jnp.asarray(known.wheels.inertia))


@dataclass(frozen=True, eq=False)
class SensorsKind(Kind):
    """Sensors of attitude, rate and wheel speeds.

    Attributes:
        estimator: Estimator that they require.
        measured: Fields of `gyrostat.scenario.schema.MEASURED` that they measure.
    """

    estimator: ClassVar[str]
    measured: ClassVar[tuple[str, ...]] = tuple(MEASURED)
    speed_sigma: Annotated[
        Scalar,
        size("speed", 0.0, "Standard deviation of a tachometer sample.", source="tachometer noise"),
    ]
    tachometer_pulses: Annotated[
        Scalar,
        Key(
            "1",
            0.0,
            "Pulses per revolution, counted over a control period; 0: no quantisation.",
            least=0.0,
            source="tachometer pulses",
            without=0.0,
        ),
    ]
    tachometer_lag: Annotated[
        Scalar,
        size("time", 0.0, "Time constant of the low-pass filter of the tachometer; 0: no filter."),
    ]
    wheel_sigma: Annotated[
        Scalar,
        size(
            "momentum",
            0.0,
            "Older form of `speed_sigma`: `speed_sigma` times the nominal rotor inertia; both add "
            "in quadrature.",
            source="tachometer noise",
        ),
    ]

    def tachometer(self, context: Context) -> WheelTachometer:
        """Tachometers of the wheels."""
        assert context.spacecraft is not None
        sigma = speed_sigma_of(self.speed_sigma, self.wheel_sigma, context.spacecraft)
        return WheelTachometer(sigma, self.tachometer_pulses, self.tachometer_lag)
