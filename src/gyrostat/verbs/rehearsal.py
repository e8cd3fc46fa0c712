"""Rehearsal of `monitor` on simulated flights."""

from pathlib import Path
from typing import TYPE_CHECKING

from gyrostat.verbs.arguments import Quantity, Say, in_si, opener_of

if TYPE_CHECKING:
    from gyrostat.monitoring.change.detector import AlarmSettings
    from gyrostat.monitoring.rehearsal import Rehearsal

REHEARSAL = "rehearsal.json"


def rehearsed(
    spacecraft: str | Path,
    out: str | Path | None,
    wheels: str | Path,
    period: Quantity,
    flights: int,
    settings: "AlarmSettings",
    *,
    scheduler: str | None,
    force: bool,
    say: Say,
) -> "Rehearsal":
    """Simulate flights of a spacecraft and monitor them; see `monitor`.

    Raises:
        InputError: A file or an argument cannot be used, or existing files would be replaced.
    """
    import json

    from gyrostat.core.errors import InputError
    from gyrostat.core.outputs import check_outputs, new_files
    from gyrostat.monitoring.fleet.flight import Cell
    from gyrostat.monitoring.fleet.pointing import LOW, SLEWS
    from gyrostat.monitoring.fleet.sampling import Sampling
    from gyrostat.monitoring.fleet.user_vehicle import assumptions, user_vehicle
    from gyrostat.monitoring.rehearsal import Plan, rehearse
    from gyrostat.monitoring.wheels_file import read_wheels

    if out is not None:
        check_outputs(Path(out), (REHEARSAL,), by="monitor", force=force)
    if flights < 1:
        raise InputError(f"--flights: found {flights}, expected 1 or more")
    seconds = in_si(period, "time", "--period")
    if not 0.1 <= seconds <= 10.0:
        raise InputError(f"--period: found {seconds:g} s, expected 0.1 s to 10 s")
    known = read_wheels(wheels, spacecraft)
    vehicle = user_vehicle(spacecraft, known)
    periods = max(1, min(8, round(seconds / vehicle.control_period)))
    cell = Cell(vehicle, LOW, SLEWS, periods=periods)
    plan = Plan(flights, sampling=Sampling(period=seconds), settings=settings)
    result = rehearse(cell, plan, assumptions(vehicle), say, opener_of(scheduler, say))
    for line in result.lines():
        say(line)
    if out is not None:
        text = json.dumps(result.as_json(), indent=1, ensure_ascii=False, allow_nan=False)
        with new_files(Path(out), by="monitor", force=force) as folder:
            (folder / REHEARSAL).write_text(text + "\n", encoding="utf-8")
    return result
