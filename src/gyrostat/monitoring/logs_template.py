"""Template of a file of columns for telemetry of any mission."""

from collections.abc import Sequence
from pathlib import Path

from gyrostat.monitoring.logs import read_table
from gyrostat.monitoring.reading import roles_of
from gyrostat.monitoring.wheel_data import KnownWheels

_EXAMPLES = {
    "time": "s",
    "speed": "rpm",
    "current": "mA",
    "power": "W",
    "torque": "N·m",
    "temperature": "°C",
}

_HEAD = (
    "# Columns of telemetry for gyrostat monitor --columns. Write the name of its column behind",
    "# each role, and delete the lines that the telemetry lacks. Needed are the time, and the",
    "# speed of each wheel; current is that of the motor, power the electrical one of wheel and",
    "# drive, torque the commanded one. A unit is needed where a column's name has none; dates, as",
    "# in 2026-03-01T12:00:00Z, need none.",
)


def columns_template(paths: Sequence[Path], known: KnownWheels) -> str:
    """File of columns to fill in: the roles of these wheels, and the columns of the files.

    Args:
        paths: Files of telemetry, CSV or Parquet; several are logs with times of their own.
        known: The wheels.

    Raises:
        InputError: A file cannot be read.
    """
    roles = {name: role for name, role in roles_of(known).items() if name != "time_fine"}
    units = {name: role.dimension for name, role in roles.items() if role.dimension is not None}
    lines = [*_HEAD]
    for path in paths:
        names = ", ".join(f'"{name}"' for name in read_table(path).column_names)
        lines += ["", "[[log]]", f'file = "{path.name}"', f"# columns: {names}", "[log.columns]"]
        lines += [f'{"" if name == "time" else "# "}{name} = ""' for name in roles]
        lines += ["[log.units]"]
        lines += [f'# {name} = "{_EXAMPLES.get(kind, "deg/s")}"' for name, kind in units.items()]
    return "\n".join([*lines, ""])
