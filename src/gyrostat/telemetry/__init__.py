"""Bench records: motor current and wheel speed over time; reading, checking and writing."""

from gyrostat.telemetry.cuts import cut
from gyrostat.telemetry.edges import record_of_edges
from gyrostat.telemetry.pool import pool
from gyrostat.telemetry.read import read_record
from gyrostat.telemetry.record import Record
from gyrostat.telemetry.write import write_record

__all__ = ["Record", "cut", "pool", "read_record", "record_of_edges", "write_record"]
