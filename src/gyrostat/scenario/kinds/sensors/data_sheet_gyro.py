"""Star tracker and a gyro with the errors of a data sheet."""

from dataclasses import dataclass, replace
from math import inf
from typing import Annotated

from gyrostat.core.arrays import Scalar, Vector3
from gyrostat.scenario.component import Context
from gyrostat.scenario.kinds.sensors.star_tracker import StarTrackerGyro
from gyrostat.scenario.schema import positive, size, vector
from gyrostat.spacecraft import DataSheetGyro, TrackerGyroSensors


@dataclass(frozen=True, eq=False)
class StarTrackerDataSheetGyro(StarTrackerGyro):
    """Star tracker, tachometers and a gyro as its data sheet states it, for the estimator `kalman`.

    See `gyrostat.spacecraft.DataSheetGyro`. The estimator assumes the walks alone, as for
    `star_tracker_gyro`. `gyrostat allan` finds the values from a record.
    """

    name = "star_tracker_data_sheet_gyro"
    bias_instability: Annotated[
        Scalar,
        size(
            "speed",
            0.0,
            "Bias instability of IEEE Std 952: the lowest Allan deviation over 0.664.",
            source="gyro bias instability",
        ),
    ]
    bandwidth: Annotated[
        Scalar,
        positive("frequency", inf, "Frequency at which the gyro has lost 3 dB, of first order."),
    ]
    nonorthogonality: Annotated[
        Vector3,
        vector(
            "angle",
            "Deviations from right angles between the axes x and y, x and z, y and z.",
            source="gyro misalignment",
        ),
    ]
    angle_resolution: Annotated[
        Scalar,
        size(
            "angle",
            0.0,
            "Step of the integrated angle: √12 times the quantisation Q.",
            source="gyro resolution",
        ),
    ]
    rate_resolution: Annotated[
        Scalar, size("speed", 0.0, "Step of the rate.", source="gyro resolution")
    ]

    def make(self, context: Context) -> TrackerGyroSensors:
        """Sensors."""
        sensors = super().make(context)
        gyro = DataSheetGyro(
            sensors.gyro,
            self.bias_instability,
            self.bandwidth,
            self.nonorthogonality,
            self.angle_resolution,
            self.rate_resolution,
        )
        return replace(sensors, gyro=gyro)
