"""Magnetometer."""

from dataclasses import dataclass
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.sampled_kind import SampledKind
from gyrostat.scenario.schema import size, vector
from gyrostat.spacecraft.sensors.magnetometer import Magnetometer


@dataclass(frozen=True, eq=False)
class MagnetometerKind(SampledKind):
    """Magnetic flux density in body axes, (3,) (`gyrostat.spacecraft.Magnetometer`)."""

    name = "magnetometer"
    sensor = Magnetometer
    unit = "T"
    sigma: Annotated[
        Scalar,
        size("flux_density", 0.0, "Standard deviation of the noise of each axis.", source="noise"),
    ]
    bias: Annotated[Vector3, vector("flux_density", "Bias, in body axes.", source="bias")]
    scale_factor: Annotated[
        Vector3, vector("1", "Scale factor error of each axis.", source="scale factor")
    ]
    misalignment: Annotated[
        Vector3,
        vector("angle", "Rotation vector from body to magnetometer axes.", source="misalignment"),
    ]
