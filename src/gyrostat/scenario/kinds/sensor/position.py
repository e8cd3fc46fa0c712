"""Position from satellite navigation."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.sampled_kind import SampledKind
from gyrostat.scenario.schema import size, vector
from gyrostat.spacecraft.sensors.position_sensor import PositionSensor


@dataclass(frozen=True, eq=False)
class Position(SampledKind):
    """Position from satellite navigation, GCRS, (3,) (`gyrostat.spacecraft.PositionSensor`)."""

    name = "position"
    sensor = PositionSensor
    unit = "m"
    sigma: Annotated[
        Scalar, size("length", 0.0, "Standard deviation of the noise of each axis.", source="noise")
    ]
    bias: Annotated[Vector3, vector("length", "Bias, GCRS.", source="bias")]
