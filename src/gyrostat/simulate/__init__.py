"""Running models: so far the virtual bench."""

from gyrostat.simulate.bench import CurrentRange, Telemetry, bench_record, default_range

__all__ = ["CurrentRange", "Telemetry", "bench_record", "default_range"]
