"""Bench records: motor current and wheel speed over time; reading, checking and writing."""

from gyrostat.telemetry.read import read_record
from gyrostat.telemetry.record import Record
from gyrostat.telemetry.write import write_record

__all__ = ["Record", "read_record", "write_record"]
