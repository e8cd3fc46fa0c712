"""What carries the wheels, and how its motion is measured."""

from gyrostat.body.gyro import Gyro, TableMeasurement, TableSensors, TrueTurn, Turn
from gyrostat.body.table import AirBearingTable, DriveRecord, TableCommand, TableState

__all__ = [
    "AirBearingTable",
    "DriveRecord",
    "Gyro",
    "TableCommand",
    "TableMeasurement",
    "TableSensors",
    "TableState",
    "TrueTurn",
    "Turn",
]
