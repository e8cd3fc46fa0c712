"""What carries the wheels, and how its motion is measured."""

from gyrostat.body import rotations
from gyrostat.body.bench_wheel import (
    BenchRecord,
    BenchWheel,
    BenchWheelState,
    MomentumMeasurement,
    MomentumSensor,
    TorqueCommand,
)
from gyrostat.body.gyro import Gyro, TableMeasurement, TableSensors, TrueTurn, Turn
from gyrostat.body.rotations import EulerAngles
from gyrostat.body.spacecraft import Spacecraft, check_inertia
from gyrostat.body.table import AirBearingTable, DriveRecord, TableCommand, TableState

__all__ = [
    "AirBearingTable",
    "BenchRecord",
    "BenchWheel",
    "BenchWheelState",
    "DriveRecord",
    "EulerAngles",
    "Gyro",
    "MomentumMeasurement",
    "MomentumSensor",
    "Spacecraft",
    "TableCommand",
    "TableMeasurement",
    "TableSensors",
    "TableState",
    "TorqueCommand",
    "TrueTurn",
    "Turn",
    "check_inertia",
    "rotations",
]
