"""Files of a fleet: telemetry, truth, events and the description of the spacecraft."""

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gyrostat.monitoring.fleet.flight import DAY, Fleet, Flight, FlightDay
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.sampling import Sampling, sample
from gyrostat.monitoring.fleet.vehicle import Vehicle
from gyrostat.monitoring.wheel_data import KnownWheels

_VALUES = (
    *("inertia", "motor_constant", "coulomb", "viscous", "stribeck_speed"),
    *("idle_power", "resistance"),
)


def write_fleet(folder: Path, fleet: Fleet, days: int, sampling: Sampling) -> None:
    """Fly a batch and write one folder for each flight.

    `telemetry.parquet` has one row group a day; `truth.parquet` one row for each wheel and day;
    `events.json` the faults; `spacecraft.toml` the spacecraft with its nominal wheels;
    `wheels.toml` what the monitor may know of them.

    Args:
        folder: Folder of the flights; it is created.
        fleet: Batch of flights.
        days: Number of days.
        sampling: Telemetry chain.
    """
    import pyarrow
    import pyarrow.parquet

    paths = [folder / f"flight{flight.number}" for flight in fleet.flights]
    writers: list[pyarrow.parquet.ParquetWriter] = []
    truth: list[list[dict[str, float]]] = [[] for _ in paths]
    for path, flight in zip(paths, fleet.flights, strict=True):
        path.mkdir(parents=True, exist_ok=True)
        (path / "spacecraft.toml").write_text(spacecraft_text(fleet.cell.vehicle), "utf-8")
        (path / "wheels.toml").write_text(
            wheels_text(known_wheels(fleet.cell.vehicle, sampling)), "utf-8"
        )
        (path / "events.json").write_text(json.dumps(events(flight), indent=1), "utf-8")
    try:
        for flown in fleet.days(days):
            for b, day in enumerate(flown):
                columns = sample(day, fleet.cell.vehicle, sampling)
                table = pyarrow.table(_stored(columns))
                if len(writers) <= b:
                    file = paths[b] / "telemetry.parquet"
                    writers.append(pyarrow.parquet.ParquetWriter(file, table.schema))
                writers[b].write_table(table)
                truth[b] += truth_rows(day)
    finally:
        for writer in writers:
            writer.close()
    for path, rows in zip(paths, truth, strict=True):
        pyarrow.parquet.write_table(pyarrow.Table.from_pylist(rows), path / "truth.parquet")


def _stored(columns: dict[str, NDArray]) -> dict[str, NDArray]:
    """Columns as a receiving station stores them: single precision, times apart."""
    single = {n: v.astype(np.float32) for n, v in columns.items() if v.dtype == np.float64}
    return columns | single | {"time_s": columns["time_s"]}


def truth_rows(day: FlightDay) -> list[dict[str, float]]:
    """True values of each wheel on a day."""
    return [
        {
            "flight": day.flight.number,
            "wheel": k + 1,
            "start": DAY * day.day,
            "end": DAY * (day.day + 1),
            **{name: float(values[k]) for name, values in day.truth.items()},
        }
        for k in range(day.speed.shape[1])
    ]


def events(flight: Flight) -> list[dict[str, float | str]]:
    """Faults of a flight, with the date in days from its start."""
    return [
        {
            "wheel": fault.wheel + 1,
            "class": fault.name,
            "day": fault.day,
            "size": fault.size,
            "duration": fault.duration,
        }
        for fault in flight.faults
    ]


def spacecraft_text(vehicle: Vehicle) -> str:
    """Spacecraft file with the nominal wheels.

    Args:
        vehicle: Spacecraft.
    """
    wheel = vehicle.wheel
    text = f'[body]\nname = "{vehicle.name}"\ninertia = {_row(vehicle.inertia)}\n'
    for k in range(vehicle.count):
        text += (
            f'\n[[wheel]]\nname = "wheel{k + 1}"\naxis = {_row(vehicle.axes[:, k])}\n'
            f"inertia = {wheel.inertia!r}\ntorque_limit = {wheel.torque_limit!r}\n"
            f'friction = {{ kind = "stribeck", viscous = {wheel.viscous!r}, '
            f"coulomb = {wheel.coulomb!r}, static = {wheel.static!r}, "
            f"stribeck_speed = {wheel.stribeck_speed!r} }}\n"
        )
    return text


def wheels_text(known: KnownWheels) -> str:
    """File of what is known of the wheels.

    Args:
        known: The wheels.
    """
    text = (
        f"[telemetry]\nspeed_resolution = {known.speed_resolution!r}\n"
        f"power_resolution = {known.power_resolution!r}\n"
        f"modes_left_out = {list(known.modes_left_out)}\n"
    )
    for wheel in known.wheels:
        text += f'\n[[wheel]]\nname = "{wheel.name}"\n'
        for name in _VALUES:
            text += f"{name} = {getattr(wheel, name)!r}\n"
        text += "\n[wheel.sigma]\n"
        text += "".join(f"{name} = {value!r}\n" for name, value in wheel.sigma.items())
    return text


def _row(values: NDArray) -> str:
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"
