"""Running models: the closed loop, and the virtual bench."""

from gyrostat.simulation.bench import CurrentRange, Telemetry, bench_record, default_range
from gyrostat.simulation.labels import status_attributes
from gyrostat.simulation.loop import (
    Controller,
    Histories,
    Plant,
    Sensor,
    Status,
    loop_parts,
    run,
    run_folded,
    stretch,
)
from gyrostat.simulation.simulation import Batch, labelled, simulate, stack

simulate_loop = simulate
"""`simulate` under the name that it has at the root, where `simulate` takes a scenario."""

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
    "labelled",
    "loop_parts",
    "run",
    "run_folded",
    "simulate",
    "simulate_loop",
    "stack",
    "status_attributes",
    "stretch",
]
