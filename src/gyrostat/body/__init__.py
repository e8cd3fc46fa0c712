"""What carries the wheels, and how its motion is measured."""

from gyrostat.body.bench_wheel import (
    BenchRecord,
    BenchWheel,
    BenchWheelState,
    MomentumMeasurement,
    MomentumSensor,
    TorqueCommand,
)
from gyrostat.body.gyro import Gyro, TableMeasurement, TableSensors, TrueTurn, Turn
from gyrostat.body.table import AirBearingTable, DriveRecord, TableCommand, TableState

__all__ = [
    "AirBearingTable",
    "BenchRecord",
    "BenchWheel",
    "BenchWheelState",
    "DriveRecord",
    "Gyro",
    "MomentumMeasurement",
    "MomentumSensor",
    "TableCommand",
    "TableMeasurement",
    "TableSensors",
    "TableState",
    "TorqueCommand",
    "TrueTurn",
    "Turn",
]
