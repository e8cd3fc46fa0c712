"""Closed-loop simulation, and the virtual bench."""

from gyrostat.simulation.bench import CurrentRange, Telemetry, bench_record, default_range
from gyrostat.simulation.labels import labelled, status_attributes
from gyrostat.simulation.loop import (
    Controller,
    Histories,
    Loop,
    Plant,
    Sensor,
    Status,
    control_loop,
    run,
)
from gyrostat.simulation.runner import Runner, blocks, by_engine
from gyrostat.simulation.simulation import Batch, simulate, stack

simulate_loop = simulate
"""Name of `simulate` at the package root, where `simulate` takes a scenario."""

__all__ = [
    "Batch",
    "Controller",
    "CurrentRange",
    "Histories",
    "Loop",
    "Plant",
    "Runner",
    "Sensor",
    "Status",
    "Telemetry",
    "bench_record",
    "blocks",
    "by_engine",
    "control_loop",
    "default_range",
    "labelled",
    "run",
    "simulate",
    "simulate_loop",
    "stack",
    "status_attributes",
]
