"""Verb `allan`: noise of a rate gyro from a record at rest."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.core.errors import InputError
from gyrostat.verbs.arguments import Named, Quantity, Say, in_si_or_none, named, silent

if TYPE_CHECKING:
    from gyrostat.identification.gyro.result import GyroNoise
    from gyrostat.telemetry.gyro_record import GyroRecord


def allan(
    record: Any,
    out: "str | Path | None" = None,
    *,
    columns: "Mapping[str, str] | str | Path | None" = None,
    units: Named = None,
    interval: Quantity | None = None,
    shortest: Quantity | None = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.allan",
) -> "GyroNoise":
    """Find the noise of a rate gyro: Allan deviations, and the parameters of a data sheet.

    The record is that of a gyro at rest: rates, integrated angles or increments of the angle, at
    equal intervals (`gyrostat.telemetry.gyro_record`).

    Args:
        record: Path of the file; or rates, (N,) or (N, axes), rad/s, with `interval`.
        out: Folder for allan.json, allan.svg and sensors.toml, a section of a scenario; None
            writes no file.
        columns: Role -> column, such as {"rate_x": "gx"}, or a .toml file of them.
        units: Role -> unit, where the file has none.
        interval: Time from sample to sample, s, where the record has no times.
        shortest: Shortest averaging time of the fit, s; leaves out frequencies that the bandwidth
            of the gyro or vibration shapes. None: that of a sample.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Unused; every verb has it.

    Returns:
        Allan deviations and parameters of each axis; `plot()` draws them.

    Raises:
        InputError: The record cannot be read or used, is too short, or existing files would be
            replaced.
    """
    import numpy as np

    from gyrostat.core.outputs import check_outputs
    from gyrostat.identification.gyro.fit import FEWEST_SAMPLES, axis_noise
    from gyrostat.identification.gyro.result import GyroNoise
    from gyrostat.reports.allan import FILES, write_allan

    if out is not None:
        check_outputs(Path(out), FILES, by="allan", force=force)
    step = in_si_or_none(interval, "time", "--interval")
    if step is not None and not step > 0.0:
        raise InputError(f"--interval: found {step:g} s, expected a time above 0")
    measured = _record(record, columns, named(units, "--units"), step)
    least = in_si_or_none(shortest, "time", "--shortest") or measured.interval
    averaged = int(np.round(least / measured.interval))
    if averaged < 1:
        raise InputError(
            f"--shortest: found {least:g} s, expected the {measured.interval:g} s of a sample, or "
            "more"
        )
    samples = measured.rate.shape[1]
    if samples // averaged < FEWEST_SAMPLES:
        raise InputError(
            f"{measured.name}: found {samples // averaged} samples of "
            f"{averaged * measured.interval:g} s, expected at least {FEWEST_SAMPLES}"
        )
    result = GyroNoise(
        measured.name,
        measured.interval,
        samples,
        tuple(
            axis_noise(axis, rate, measured.interval, averaged)
            for axis, rate in zip(measured.axes, measured.rate, strict=True)
        ),
        averaged * measured.interval,
    )
    for line in result.lines():
        say(line)
    if out is not None:
        write_allan(result, Path(out), say=say, force=force)
    return result


def _record(
    record: Any,
    columns: "Mapping[str, str] | str | Path | None",
    units: Mapping[str, str],
    interval: float | None,
) -> "GyroRecord":
    """Record of a file or of an array."""
    import numpy as np

    from gyrostat.telemetry.gyro_record import AXES, GyroRecord, read_gyro_record
    from gyrostat.verbs.wheel_arguments import assigned

    if isinstance(record, str | Path):
        return read_gyro_record(record, assigned(columns, "--columns"), units, interval)
    try:
        rate = np.array(record, dtype=float).T
    except (TypeError, ValueError):
        raise InputError(
            f"record: found {type(record).__name__}, expected a path, or an array of rates"
        ) from None
    rate = rate[None] if rate.ndim == 1 else rate
    if rate.ndim != 2 or not 1 <= rate.shape[0] <= len(AXES) or rate.shape[1] < 2:
        raise InputError(
            f"record: found an array of shape {np.shape(record)}, expected (N,) or (N, axes)"
        )
    if interval is None:
        raise InputError("--interval: found none, expected the time between the rates of an array")
    return GyroRecord("record", interval, AXES[: rate.shape[0]], rate)
