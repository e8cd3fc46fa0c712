"""Sun sensors."""

from dataclasses import dataclass
from math import pi
from typing import Annotated

from jaxtyping import Array, Float

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.sampled_kind import SampledKind
from gyrostat.scenario.schema import Key, direction, positive, size, vector
from gyrostat.spacecraft.sensors.sun_sensor import FACES, CoarseSunSensors, SunSensor


@dataclass(frozen=True, eq=False)
class SunSensorKind(SampledKind):
    """Direction of the Sun in body axes, (3,), zero if it is not seen.

    See `gyrostat.spacecraft.SunSensor`.
    """

    name = "sun_sensor"
    sensor = SunSensor
    sigma: Annotated[
        Scalar,
        size("angle", 0.0, "Standard deviation of the error about each axis.", source="noise"),
    ]
    misalignment: Annotated[
        Vector3, vector("angle", "Rotation vector from body to sensor axes.", source="misalignment")
    ]
    boresight: Annotated[Vector3, direction("Boresight in body axes, of any length.")]
    field_of_view: Annotated[
        Scalar, positive("angle", pi, "Largest angle between boresight and Sun.", most=pi)
    ]


@dataclass(frozen=True, eq=False)
class CoarseSunSensorsKind(SampledKind):
    """Currents of six sun cells on the faces +x, -x, +y, -y, +z, -z, (6,), 1 at normal incidence.

    See `gyrostat.spacecraft.CoarseSunSensors`. Albedo is not modelled.
    """

    name = "coarse_sun_sensors"
    sensor = CoarseSunSensors
    sigma: Annotated[
        Scalar, size("1", 0.0, "Standard deviation of the noise of each cell.", source="noise")
    ]
    scale_factor: Annotated[
        Float[Array, "6"],
        Key(
            "1",
            0.0,
            "Relative error of the current of each cell.",
            shape=(len(FACES),),
            source="scale factor",
        ),
    ]
