"""Simulated record of a known wheel, a mode of the verb `bench`."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Quantity, Say, in_si, in_si_or_none
from gyrostat.verbs.wheel_arguments import wheel_model

if TYPE_CHECKING:
    from gyrostat.identification import Fit
    from gyrostat.telemetry import Record
    from gyrostat.wheel import Wheel, WheelModel


def bench_record_file(
    model: "WheelModel | Wheel | Fit | str | Path",
    path: Path | None,
    profile: str,
    *,
    duration: Quantity,
    telemetry: Mapping[str, Any],
    amplitudes: tuple[Quantity | None, Quantity | None],
    initial_speed: Quantity,
    period: Quantity | None,
    seed: int,
    force: bool,
    say: Say,
) -> "Record":
    """Simulate a record and write it; see `gyrostat.verbs.wheels.bench`.

    Args:
        model: Wheel, its model, an identification, or path of model.toml.
        path: File for the record; None writes no file.
        profile: Name of the current profile.
        duration: Duration of the record, s.
        telemetry: rate, speed_sigma, speed_quantum, jitter and dropouts.
        amplitudes: Smallest and largest current amplitude, A; None for the usual ones.
        initial_speed: Speed at the first sample, rad/s.
        period: Period of the profile, s.
        seed: Seed of currents and noise.
        force: Whether to replace a file that gyrostat did not write, and to accept an impossible
            wheel.
        say: Function that receives each message.

    Raises:
        InputError: An argument cannot be used, or an existing file would be replaced.
    """
    from gyrostat.core.files import check_writable
    from gyrostat.core.outputs import new_files
    from gyrostat.simulation import CurrentRange, Telemetry, bench_record, default_range
    from gyrostat.telemetry import write_record

    if path is not None:
        check_writable(path.parent)
    wheel = wheel_model(model, force=force).wheel()
    usual = default_range(wheel)
    low, high = amplitudes
    record = bench_record(
        wheel,
        profile,
        duration=in_si(duration, "time", "--duration"),
        telemetry=Telemetry(
            rate=telemetry["rate"],
            speed_sigma=in_si(telemetry["speed_sigma"], "speed", "--speed-sigma"),
            speed_quantum=in_si(telemetry["speed_quantum"], "speed", "--speed-quantum"),
            jitter=telemetry["jitter"],
            dropouts=telemetry["dropouts"],
        ),
        amplitudes=CurrentRange(
            usual.low if low is None else in_si(low, "current", "--low"),
            usual.high if high is None else in_si(high, "current", "--high"),
        ),
        initial_speed=in_si(initial_speed, "speed", "--initial-speed"),
        period=in_si_or_none(period, "time", "--period"),
        seed=seed,
        name="bench" if path is None else path.name,
    )
    if path is not None:
        if path.suffix.lower() not in (".csv", ".parquet"):
            raise InputError(f"--out: found {str(path)!r}, expected a name in .csv or .parquet")
        with new_files(path.parent, by="bench", force=force) as folder:
            write_record(record, folder / path.name)
        source = model if isinstance(model, str | Path) else type(model).__name__
        say(f"written: {path}, {len(record.time)} samples, wheel of {source}")
    return record
