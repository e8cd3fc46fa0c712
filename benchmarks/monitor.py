"""Intervals of the health monitor on simulated fleets, and its time and memory.

    python benchmarks/monitor.py intervals [--vehicle large] [--noise 0.02] [--drives power]
    python benchmarks/monitor.py time [--days 3650]

`intervals` flies fleets with closed attitude loops and prints, for each pointing, the share of
wheel-days whose 95 % interval holds the true value, with the standard error over wheels of that of
the Coulomb torque, and errors. The wheels are known as after a bench identification (`bench`) or as
from a data sheet (`sheet`), with one error for all days of a wheel. With the electrical power as
the drive, the stated idle power, and the gain of the power, have an error as well; "motor_constant"
is then that of the measured power (docs/monitor.md). `time` monitors Parquet telemetry of 4 wheels
at 1 Hz.
"""

import argparse
import resource
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet

from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.execute import PART
from gyrostat.monitoring.fleet.flight import Cell, Fleet, Flight
from gyrostat.monitoring.fleet.pointing import CROSSINGS, HIGH, LOW, QUIET, SLEWS
from gyrostat.monitoring.fleet.sampling import RPM, Sampling, sample
from gyrostat.monitoring.fleet.vehicle import LARGE, SMALL
from gyrostat.monitoring.power import current_of_power
from gyrostat.monitoring.reading import DRIVES, read_parts
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels

FIRST = 300_000
"""Number of the first flight: none of these was looked at while the monitor was written."""
VEHICLES = {"large": (LARGE, LOW), "small": (SMALL, HIGH)}
POINTINGS = {"slews": SLEWS, "quiet": QUIET, "crossings": CROSSINGS}
KNOWN = {"bench": (0.003, 0.01, 0.002), "sheet": (0.01, 0.3, 0.02)}
"""Relative sigma of motor constant, viscous coefficient and offset (over Coulomb torque)."""
POWER = {"bench": (0.005, 0.01), "sheet": (0.05, 0.03)}
"""Relative sigma of idle power and of the gain of the measured power."""
SHOWN = ("coulomb", "coulomb_level", "motor_constant", "viscous", "offset")


@dataclass
class Tally:
    """Scores (error over sigma) and relative errors and sigmas of wheel-days, and their wheels."""

    wheels: list
    scores: list
    errors: list
    sigmas: list


def known_wheels(vehicle, truth, kind, random):
    """Wheels as known beforehand: the truth with errors, or nominal values."""
    wheel = vehicle.wheel
    nominal = (wheel.motor_constant, wheel.viscous, wheel.coulomb)
    sigma = np.array(KNOWN[kind]) * nominal
    wheels = []
    for k in range(4):
        values = np.array([wheel.motor_constant, wheel.viscous, 0.0])
        if kind == "bench":
            exact = [truth[name][k] for name in ("motor_constant", "viscous", "offset")]
            values = np.array(exact) + sigma * random.standard_normal(3)
        wheels.append(
            KnownWheel(
                f"wheel{k + 1}",
                wheel.inertia,
                values[0],
                wheel.coulomb,
                values[1],
                values[2],
                wheel.stribeck_speed,
                dict(zip(("motor_constant", "viscous", "offset"), sigma, strict=True)),
            )
        )
    return KnownWheels(tuple(wheels), vehicle.axes, np.diag(vehicle.inertia), (2.0,), 0.4 * RPM)


def with_power(known, vehicle, kind, random):
    """Wheels whose idle power is stated with an error, and the gains of their measured powers."""
    wheel, (idle, gain) = vehicle.wheel, POWER[kind]
    errors = random.standard_normal((4, 2))
    wheels = tuple(
        replace(
            each,
            idle_power=wheel.idle_power * (1.0 + idle * error),
            resistance=wheel.resistance,
            sigma={**each.sigma, "idle_power": idle * wheel.idle_power, "power_gain": gain},
        )
        for each, error in zip(known.wheels, errors[:, 0], strict=True)
    )
    return replace(known, wheels=wheels, power_resolution=1e-3), 1.0 + gain * errors[:, 1]


def samples_of(columns, vehicle, drive, known, gains):
    """Columns of telemetry as the monitor takes them."""

    def per_wheel(name, unit=1.0):
        return np.stack([columns[f"wheel{k}_{name}"] for k in range(1, 5)], axis=1) * float(unit)

    speed = per_wheel("speed_rpm", RPM)
    if drive == "torque":
        values = per_wheel("torque_N·m", 1.0 / vehicle.wheel.motor_constant)
    elif drive == "power":
        idle = vehicle.wheel.idle_power
        values = current_of_power(idle + (per_wheel("power_W") - idle) * gains, speed, known)
    else:
        values = per_wheel("current_A")
    return Samples(
        columns["time_s"],
        speed,
        values,
        None,
        np.repeat(columns["temperature_degC"][:, None], 4, axis=1),
        columns["mode"].astype(float),
    )


def intervals(arguments):
    """Fly fleets and print the table."""
    vehicle, orbit = VEHICLES[arguments.vehicle]
    vehicle = replace(vehicle, slew_time=arguments.slew_time or vehicle.slew_time)
    shown = ", ".join(SHOWN)
    print(f"| pointing | drive | known from | inside, {shown} (standard error of the first) | "
          "Coulomb sigma, rms | wheel-days")  # fmt: skip
    for name in arguments.pointings:
        pointing = POINTINGS[name]
        place = [*VEHICLES].index(arguments.vehicle), [*POINTINGS].index(name)
        random = np.random.default_rng([8, *place, round(1e6 * arguments.noise)])
        cell = Cell(vehicle, orbit, pointing, noise_sigma=arguments.noise)
        flights = [Flight(FIRST + k) for k in range(arguments.flights)]
        cases = [(drive, kind) for drive in arguments.drives for kind in KNOWN]
        monitors, gains, truth = {}, {}, [[] for _ in flights]
        for flown in Fleet(cell, flights).days(arguments.days):
            for b, day in enumerate(flown):
                truth[b].append(day.truth)
                columns = sample(day, vehicle, Sampling(returned=arguments.returned))
                for drive, kind in cases:
                    case = b, drive, kind
                    if day.day == 0:
                        known, gains[case] = known_wheels(vehicle, day.truth, kind, random), None
                        if drive == "power":
                            known, gains[case] = with_power(known, vehicle, kind, random)
                        monitors[case] = WheelMonitor(known, drive=drive)
                    known = monitors[case].known
                    samples = samples_of(columns, vehicle, drive, known, gains[case])
                    monitors[case].add(samples)
        for drive, kind in cases:
            tally = Tally([], [], [], [])
            for b in range(len(flights)):
                case = b, drive, kind
                stated = [wheel.motor_constant for wheel in monitors[case].known.wheels]
                motor = None if gains[case] is None else stated / gains[case]
                count(tally, b, monitors[case].windows(), truth[b], motor)
            if not tally.scores:
                print(f"| {name} | {drive} | {kind} | no valid wheel-day | | 0")
                continue
            scores, errors = np.array(tally.scores), np.array(tally.errors)
            held = np.abs(scores) < 1.96
            inside = " ".join(f"{100 * x:.0f}" for x in np.mean(held, axis=0))
            spread = spread_over_wheels(held[:, 0], np.array(tally.wheels))
            sigma, rms = np.median(tally.sigmas), np.sqrt(np.mean(errors**2))
            inside += f" ({100 * spread:.1f})"
            print(f"| {name} | {drive} | {kind} | {inside} | {100 * sigma:.2f} {100 * rms:.2f} % | "
                  f"{len(errors)}")  # fmt: skip


def spread_over_wheels(held, wheels):
    """Standard error of a share of wheel-days, whose wheels are independent and days are not."""
    away = np.bincount(wheels, held - np.mean(held))
    return np.sqrt(np.sum(away**2)) / held.size


def count(tally, flight, table, truth, motor=None):
    """Add the wheel-days of a flight; `motor` replaces the true motor constants."""
    for row in range(len(table)):
        if not table["valid"][row]:
            continue
        day, wheel = int(table["start"][row] // 86400), int(str(table["wheel"][row])[-1]) - 1
        exact = {name: truth[day][name][wheel] for name in SHOWN}
        if motor is not None:
            exact["motor_constant"] = motor[wheel]
        tally.wheels.append(4 * flight + wheel)
        tally.scores.append([(table[n][row] - exact[n]) / table[f"{n}_sigma"][row] for n in SHOWN])
        tally.errors.append(table["coulomb"][row] / exact["coulomb"] - 1.0)
        tally.sigmas.append(table["coulomb_sigma"][row] / exact["coulomb"])


def timing(arguments):
    """Monitor telemetry from a Parquet file of ten days, read again and again with later times."""
    vehicle, orbit = VEHICLES["large"]
    flown = [day for (day,) in Fleet(Cell(vehicle, orbit, SLEWS), [Flight(FIRST)]).days(10)]
    known = known_wheels(vehicle, flown[0].truth, "bench", np.random.default_rng(0))
    spent = {"reading": 0.0, "monitoring": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "telemetry.parquet"
        tables = [pyarrow.table(sample(day, vehicle, Sampling())) for day in flown]
        pyarrow.parquet.write_table(pyarrow.concat_tables(tables), path, row_group_size=86400)
        del tables, flown
        monitor = WheelMonitor(known)
        wall, before = time.monotonic(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for number in range(arguments.days // 10):
            monitor.begin_file()
            parts = read_parts(path, known, part=PART)
            while True:
                clock = time.process_time()
                part = next(parts, None)
                spent["reading"] += time.process_time() - clock
                if part is None:
                    break
                clock = time.process_time()
                later = part.samples.time + 864000.0 * number
                monitor.add(replace(part.samples, time=later))
                spent["monitoring"] += time.process_time() - clock
            if number in (1, arguments.days // 10 - 1):
                after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
                print(f"{10 * (number + 1)} days: {after / 1024:.0f} MB at most")
    days = 10 * (arguments.days // 10)
    print(f"{days} days of 4 wheels at 1 Hz, {len(monitor.windows())} windows")
    print(f"processor: {', '.join(f'{k} {v:.1f} s' for k, v in spent.items())}; memory before "
          f"{before / 1024:.0f} MB; {time.monotonic() - wall:.0f} s in all")  # fmt: skip
    print(f"{1e3 * spent['monitoring'] / (4 * days):.1f} ms per wheel-day without reading")


parser = argparse.ArgumentParser(description=__doc__)
verbs = parser.add_subparsers(required=True)
verb = verbs.add_parser("intervals")
verb.add_argument("--vehicle", choices=VEHICLES, default="large")
verb.add_argument("--noise", type=float, default=0.02)
verb.add_argument("--flights", type=int, default=12)
verb.add_argument("--days", type=int, default=4)
verb.add_argument("--drives", nargs="+", choices=DRIVES, default=["current", "torque"])
verb.add_argument("--pointings", nargs="+", choices=POINTINGS, default=[*POINTINGS])
verb.add_argument("--slew-time", type=float, help="duration of slews, s")
verb.add_argument("--returned", type=float, default=1.0, help="share of the power of braking")
verb.set_defaults(run=intervals)
verb = verbs.add_parser("time")
verb.add_argument("--days", type=int, default=3650)
verb.set_defaults(run=timing)

if __name__ == "__main__":
    arguments = parser.parse_args()
    arguments.run(arguments)
