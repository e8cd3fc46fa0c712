"""Verb `monitor`: health of wheels in flight from their telemetry."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyrostat.verbs.arguments import (
    Quantity,
    Say,
    in_si,
    in_si_or_none,
    named,
    refuse_given,
    silent,
)
from gyrostat.verbs.rehearsal import rehearsed
from gyrostat.verbs.telemetry_logs import joined_telemetry, write_template

if TYPE_CHECKING:
    from gyrostat.monitoring import Health
    from gyrostat.monitoring.rehearsal import Rehearsal

STATE = "monitor.state"
FILES = ("health.json", "windows.parquet", "report.html")


def monitor(
    telemetry: "Sequence[str | Path] | str | Path | None" = None,
    out: "str | Path | None" = None,
    *,
    wheels: str | Path,
    spacecraft: str | Path | None = None,
    columns: Mapping[str, str] | str | Path | None = None,
    units: Mapping[str, str] | str | None = None,
    window: Quantity = "1d",
    false_alarms: float = 0.32,
    fault_rates: "Mapping[str, float] | str | None" = None,
    friction_limit: Quantity | None = None,
    restart: bool = False,
    columns_template: bool = False,
    rehearse: "str | Path | None" = None,
    period: Quantity = "1s",
    flights: int = 3,
    scheduler: str | None = None,
    force: bool = False,
    say: Say = silent,
    command: str = "gyrostat.monitor",
) -> "Health | Rehearsal | Path":
    """Estimate friction and motor of wheels in flight, window by window.

    Args:
        telemetry: Files of telemetry; None with `rehearse`. A further call with the same `out`
            goes on where the telemetry ended.
        out: Folder for health.json, windows.parquet, report.html, the wheel of the last valid
            window (wheels/NAME/model.toml) and the state between calls; None writes no file.
        wheels: File of what is known of the wheels beforehand (`gyrostat.monitoring.wheels_file`).
        spacecraft: Spacecraft file with the axes of the wheels and the inertia of the body.
        columns: Role -> column, or a .toml file of them (`gyrostat.monitoring.reading`); a file of
            several logs (`gyrostat.monitoring.logs`) has them joined into telemetry.parquet.
        units: Role -> unit, if the files have none.
        window: Length of a window, s; a multiple of a minute.
        false_alarms: Highest expected number of false alarms per wheel-year.
        fault_rates: Class of change -> faults per wheel-year, an assumption that the probabilities
            of the classes depend on; classes that are left out keep their usual rate.
        friction_limit: Friction torque at the usual speed whose day is forecast, N·m.
        restart: Whether to forget the state in `out`.
        columns_template: Whether to write only columns.toml, a file of columns to fill in, with the
            roles of the wheels and the columns of the telemetry.
        rehearse: Spacecraft file with three or four wheels, instead of telemetry: flights of this
            spacecraft are simulated, healthy and with each fault, and monitored.
        period: With `rehearse`: time between rows of telemetry, s.
        flights: With `rehearse`: number of healthy flights, and of flights with each fault.
        scheduler: With `rehearse`: address of a Dask scheduler, whose workers fly one fault each.
            Telemetry is one stream: each window starts from the one before it.
        force: Whether to replace files that gyrostat did not write.
        say: Function that receives each message for the user.
        command: Text that the page names as its origin.

    Returns:
        Window table, remarks and alarms; with `rehearse`, false alarms, and alarms and delays for
        each fault, written to rehearsal.json; with `columns_template`, the path of columns.toml.

    Raises:
        InputError: A file or an argument cannot be used, or existing files would be replaced.
    """
    from gyrostat.core.errors import InputError
    from gyrostat.core.outputs import check_outputs
    from gyrostat.core.validation import require
    from gyrostat.monitoring.change.detector import alarm_settings
    from gyrostat.monitoring.execute import Options, monitor_files
    from gyrostat.monitoring.wheels_file import read_wheels
    from gyrostat.verbs.wheel_arguments import assigned

    alarm = alarm_settings(false_alarms, named(fault_rates, "--fault-rates"))
    if rehearse is not None:
        if telemetry:
            raise InputError("--rehearse: found telemetry too, expected one of the two")
        options = {"scheduler": scheduler, "force": force, "say": say}
        return rehearsed(rehearse, out, wheels, period, flights, alarm, **options)
    refuse_given({"--scheduler": scheduler}, "telemetry", "--rehearse")
    if not telemetry:
        raise InputError("telemetry: found no file, expected files of telemetry, or --rehearse")
    known = read_wheels(wheels, spacecraft)
    files = [Path(f) for f in ([telemetry] if isinstance(telemetry, str | Path) else telemetry)]
    if columns_template:
        if out is None:
            raise InputError("columns_template: found no out, expected the folder to write it to")
        path = write_template(files, known, Path(out), force=force)
        say(f"written: {path}: fill in the columns")
        return path
    if out is not None:
        check_outputs(Path(out), FILES, by="monitor", force=force)
    limit = in_si_or_none(friction_limit, "torque", "--friction-limit")
    if limit is not None:
        require("--friction-limit", limit, "N·m", positive=True)
    options = Options(
        assigned(columns, "--columns"),
        named(units, "--units") or None,
        in_si(window, "time", "--window"),
        alarm,
        limit,
    )
    folder = None if out is None else Path(out)
    with joined_telemetry(files, options.columns, known, folder, force=force) as (paths, chosen):
        health = monitor_files(
            paths,
            known,
            replace(options, columns=chosen),
            state=None if folder is None else folder / STATE,
            restart=restart,
            say=say,
        )
    if out is not None:
        _write(health, Path(out), known, command=command, force=force)
    for line in health.lines():
        say(line)
    return health


def _write(health: "Health", out: Path, known: Any, *, command: str, force: bool) -> None:
    """Write the results as a whole."""
    import json

    from gyrostat.core.outputs import new_files
    from gyrostat.monitoring.today import wheel_models
    from gyrostat.monitoring.windows import write_windows
    from gyrostat.reports.health import health_page
    from gyrostat.wheel.model_file import write_model

    text = json.dumps(health.to_dict(), indent=1, ensure_ascii=False, allow_nan=False)
    with new_files(out, by="monitor", force=force) as folder:
        (folder / "health.json").write_text(text + "\n", encoding="utf-8")
        page = health_page(health, command=command)
        (folder / "report.html").write_text(page, encoding="utf-8")
        write_windows(folder / "windows.parquet", health.windows)
        for name, model in wheel_models(health, known).items():
            path = folder / "wheels" / name / "model.toml"
            path.parent.mkdir(parents=True)
            write_model(path, model)
