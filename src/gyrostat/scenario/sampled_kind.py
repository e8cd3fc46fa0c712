"""Base of further sensors that are sampled less often than the control, and used later."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from gyrostat.core.arrays import Scalar
from gyrostat.core.jax64 import jnp
from gyrostat.scenario.component import ORBIT, Context, Kind
from gyrostat.scenario.schema import Key, size
from gyrostat.spacecraft.sensors.sampled import LONGEST, Sampled


@dataclass(frozen=True, eq=False)
class SampledKind(Kind):
    """Sensor along an orbit with a sampling of its own.

    Attributes:
        sensor: Class of the sensor that measures in each period. It is called with the orbit, and
            with the values of the keys except those of the sampling.
    """

    sensor: ClassVar[Callable[..., Any]]
    needs = frozenset({ORBIT})
    periods: Annotated[
        Scalar,
        Key("1", 1.0, "Control periods between samples, rounded to a whole number.", least=1.0),
    ]
    latency: Annotated[
        Scalar,
        size(
            "1",
            0.0,
            "Control periods from a sample to its use, rounded to a whole number.",
            most=float(LONGEST),
        ),
    ]

    def make(self, context: Context) -> Sampled:
        """Sensor with its sampling."""
        assert context.orbit is not None
        options = self.options()
        periods, latency = jnp.round(options.pop("periods")), jnp.round(options.pop("latency"))
        return Sampled(type(self).sensor(context.orbit, **options), periods, latency)
