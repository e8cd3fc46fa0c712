"""Running models: the closed loop, and the virtual bench."""

from gyrostat.simulate.bench import CurrentRange, Telemetry, bench_record, default_range
from gyrostat.simulate.loop import Controller, Histories, Plant, Sensor, Status, run, run_folded
from gyrostat.simulate.simulation import Batch, simulate, stack

__all__ = [
    "Batch",
    "Controller",
    "CurrentRange",
    "Histories",
    "Plant",
    "Sensor",
    "Status",
    "Telemetry",
    "bench_record",
    "default_range",
    "run",
    "run_folded",
    "simulate",
    "stack",
]
