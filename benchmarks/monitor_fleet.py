"""Judge the monitor of flying wheels on simulated fleets, with peers on the same windows.

    python benchmarks/monitor_fleet.py fly DIR --vehicle large --orbit low --pointing slews \
        --noise 0.02 --flights 8 --days 60 [--fault "Coulomb growth"] [--first 0]
    python benchmarks/monitor_fleet.py judge DIR

`fly` writes window tables with truth, one file per batch, and goes on where it was stopped; `judge`
prints intervals, false alarms, delays and classes of all batches in DIR. Flights with numbers from
100000 on are the judging fleet: nothing was tuned on them.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
from monitor_peers import daily_numbers

from gyrostat.monitoring.fleet.flight import FAULTS, Cell, Fleet, Flight
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.pointing import CROSSINGS, HIGH, LOW, QUIET, SLEWS
from gyrostat.monitoring.fleet.sampling import UGLY, Sampling, sample
from gyrostat.monitoring.fleet.vehicle import LARGE, SMALL
from gyrostat.monitoring.rehearsal import samples_of
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.windows import Windows, write_windows

VEHICLES = {"large": LARGE, "small": SMALL}
ORBITS = {"low": LOW, "high": HIGH}
POINTINGS = {"slews": SLEWS, "quiet": QUIET, "crossings": CROSSINGS}


def fly(arguments):
    """Fly one batch and keep its window tables."""
    vehicle = VEHICLES[arguments.vehicle]
    cell = Cell(
        vehicle,
        ORBITS[arguments.orbit],
        POINTINGS[arguments.pointing],
        noise_sigma=arguments.noise,
        seed=arguments.first,
    )
    name = "-".join(
        [
            arguments.vehicle,
            arguments.orbit,
            arguments.pointing,
            f"{arguments.noise:g}",
            (arguments.fault or "healthy").replace(" ", "_"),
            str(arguments.first),
            "ugly" if arguments.ugly else arguments.drive,
        ]
    )
    path = arguments.folder / f"{name}.parquet"
    if path.exists():
        return
    numbers = range(arguments.first, arguments.first + arguments.flights)
    flights = [Flight(number, _faults(arguments, number)) for number in numbers]
    sampling = UGLY if arguments.ugly else Sampling()
    monitors = [WheelMonitor(known_wheels(vehicle, sampling)) for _ in flights]
    truth, numbers_of, speeds = [], [], np.full((len(flights), 4), np.nan)
    spent = {"fly": 0.0, "sample": 0.0, "monitor": 0.0}
    clock = time.process_time()
    for flown in Fleet(cell, flights).days(arguments.days):
        spent["fly"] -= clock - (clock := time.process_time())
        for b, (day, monitor) in enumerate(zip(flown, monitors, strict=True)):
            samples = samples_of(sample(day, vehicle, sampling), vehicle, arguments.drive)
            spent["sample"] -= clock - (clock := time.process_time())
            monitor.add(samples)
            spent["monitor"] -= clock - (clock := time.process_time())
            if day.day == 0:
                speeds[b] = np.median(np.abs(samples.speed), axis=0)
            peers = daily_numbers(samples, vehicle.wheel, speeds[b])
            numbers_of.append({key: values.tolist() for key, values in peers.items()})
            clock = time.process_time()
            truth.append({key: values.tolist() for key, values in day.truth.items()})
    tables = [monitor.windows() for monitor in monitors]
    joined = Windows(
        {column: np.concatenate([t[column] for t in tables]) for column in tables[0].columns}
    )
    flight = np.concatenate([np.full(len(t), n) for t, n in zip(tables, numbers, strict=True)])
    joined.columns["wheel"][:] = [f"{n}/{w}" for n, w in zip(flight, joined["wheel"], strict=True)]
    arguments.folder.mkdir(parents=True, exist_ok=True)
    wheel_days = 4 * arguments.days * arguments.flights
    description = {
        "vehicle": arguments.vehicle,
        "orbit": arguments.orbit,
        "pointing": arguments.pointing,
        "noise": arguments.noise,
        "fault": arguments.fault,
        "drive": arguments.drive,
        "ugly": arguments.ugly,
        "first": arguments.first,
        "flights": arguments.flights,
        "days": arguments.days,
        "ms_per_wheel_day": {k: 1e3 * v / wheel_days for k, v in spent.items()},
        "events": [
            {"flight": f.number, "wheel": x.wheel + 1, "day": x.day, "size": x.size}
            for f in flights
            for x in f.faults
        ],
        "truth": truth,
        "peers": numbers_of,
    }
    path.with_suffix(".json").write_text(json.dumps(description))
    write_windows(path, joined)
    print(name, {k: round(v, 2) for k, v in description["ms_per_wheel_day"].items()}, flush=True)


def _faults(arguments, number):
    """The same fault in each wheel, of the usual size, on days of their own; seizure in one."""
    if not arguments.fault:
        return ()
    kind = FAULTS[arguments.fault]
    random = np.random.default_rng([number, 17])
    days = arguments.earliest + 5.0 * random.uniform(0.0, 1.0, 4)
    wheels = [int(random.integers(4))] if arguments.fault == "seizure" else range(4)
    return tuple(
        kind(k, float(days[k]), kind.usual_size, kind.usual_duration, 4 * number + k)
        for k in wheels
    )


def main():
    """Run a command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True)
    flying = commands.add_parser("fly")
    flying.add_argument("folder", type=Path)
    flying.add_argument("--vehicle", choices=VEHICLES, default="large")
    flying.add_argument("--orbit", choices=ORBITS, default="low")
    flying.add_argument("--pointing", choices=POINTINGS, default="slews")
    flying.add_argument("--noise", type=float, default=0.02)
    flying.add_argument("--fault", choices=FAULTS)
    flying.add_argument("--drive", choices=("current", "torque"), default="current")
    flying.add_argument("--ugly", action="store_true")
    flying.add_argument("--flights", type=int, default=8)
    flying.add_argument("--first", type=int, default=0)
    flying.add_argument("--days", type=int, default=60)
    flying.add_argument("--earliest", type=float, default=25.0)
    flying.set_defaults(run=fly)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
