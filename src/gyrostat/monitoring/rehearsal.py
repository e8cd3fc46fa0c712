"""Rehearsal: alarms, delays and false alarms to expect from a user's wheels and telemetry.

Simulated flights of the spacecraft go through the monitor as telemetry of its own would: healthy
ones, and ones with each fault.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from gyrostat.campaigns.executors import Opener
from gyrostat.campaigns.mapped import mapped
from gyrostat.core.pictured import Described, PicturedText
from gyrostat.monitoring.blocks import Samples
from gyrostat.monitoring.change.assess import WheelHealth, assess, reference_to
from gyrostat.monitoring.change.detector import YEAR, AlarmSettings
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.flight import FAULTS, Cell, Fleet, Flight
from gyrostat.monitoring.fleet.known import known_wheels
from gyrostat.monitoring.fleet.sampling import RPM, Sampling, sample
from gyrostat.monitoring.fleet.vehicle import Vehicle
from gyrostat.monitoring.power import current_of_power
from gyrostat.monitoring.stream import WheelMonitor
from gyrostat.monitoring.windows import REGRESSED, Windows

ONSET = 20.0
"""First day on which a fault begins; it begins within five days from it."""
AFTER = 20
"""Days of a flight after the last onset."""


@dataclass(frozen=True)
class Plan:
    """Size of a rehearsal.

    Attributes:
        flights: Flights of each fault, and healthy ones.
        days: Days of the healthy flights.
        sampling: Telemetry chain.
        settings: Settings of alarms and classes.
    """

    flights: int = 3
    days: int = 60
    sampling: Sampling = field(default_factory=Sampling)
    settings: AlarmSettings = field(default_factory=AlarmSettings)


@dataclass(frozen=True)
class Expected(Described):
    """What to expect of one fault.

    Attributes:
        size: Size of the fault; its meaning is that of `monitoring/fleet/faults`.
        wheels: Number of wheels.
        alarms: Wheels with an alarm after the onset, within the flight.
        delay: Median days to the alarm; infinite if most wheels have none.
        right: Wheels whose class is right at the end.
        among: Wheels whose class is among those that cannot be told apart at the end.
    """

    size: float
    wheels: int
    alarms: int
    delay: float
    right: int
    among: int


@dataclass(frozen=True, eq=False)
class Rehearsal(PicturedText):
    """Result of a rehearsal.

    Attributes:
        wheel_years: Healthy wheel-years.
        false_alarms: False alarms in them; alarms less than 14 days apart are one.
        sigma: Parameter -> median standard deviation of a window over the value.
        observable: Parameter -> share of windows in which it is observable.
        faults: Class -> what to expect of it.
        assumptions: What is assumed beside the files, one line each.
    """

    wheel_years: float
    false_alarms: int
    sigma: Mapping[str, float]
    observable: Mapping[str, float]
    faults: Mapping[str, Expected]
    assumptions: tuple[str, ...] = ()

    def rate(self) -> tuple[float, float]:
        """95 % interval of the false alarms per wheel-year."""
        low = chi2.ppf(0.025, 2 * self.false_alarms) / 2.0 if self.false_alarms else 0.0
        high = chi2.ppf(0.975, 2 * self.false_alarms + 2) / 2.0
        return float(low / self.wheel_years), float(high / self.wheel_years)

    def as_json(self) -> dict[str, Any]:
        """Content of rehearsal.json."""
        low, high = self.rate()
        return {
            "healthy": {
                "wheel_years": self.wheel_years,
                "false_alarms": self.false_alarms,
                "false_alarms_per_wheel_year": [low, high],
                "sigma": dict(self.sigma),
                "observable": dict(self.observable),
            },
            "faults": {
                name: {
                    "size": each.size,
                    "wheels": each.wheels,
                    "alarms": each.alarms,
                    "median_delay_days": each.delay if np.isfinite(each.delay) else None,
                    "class_right": each.right,
                    "class_among": each.among,
                }
                for name, each in self.faults.items()
            },
            "assumptions": list(self.assumptions),
        }

    def lines(self) -> Iterator[str]:
        """Text for the terminal."""
        low, high = self.rate()
        yield (
            f"healthy: {self.false_alarms} false alarms in {self.wheel_years:.1f} wheel-years "
            f"({low:.2g} to {high:.2g} per wheel-year, 95 %)"
        )
        for name in REGRESSED:
            yield (
                f"  {name:<15} {100.0 * self.sigma[name]:.2g} % a window, observable in "
                f"{100.0 * self.observable[name]:.0f} % of windows"
            )
        for name, each in self.faults.items():
            delay = f"{each.delay:.0f} days" if np.isfinite(each.delay) else "none"
            yield (
                f"{name} of {each.size:g}: alarm in {each.alarms} of {each.wheels} wheels, median "
                f"delay {delay}, class right in {each.right}, one of two or three in {each.among}"
            )
        for line in self.assumptions:
            yield f"assumed: {line}"


def rehearse(
    cell: Cell,
    plan: Plan,
    assumptions: tuple[str, ...] = (),
    say: Callable[[str], None] = lambda message: None,
    opener: Opener | None = None,
) -> Rehearsal:
    """Fly healthy flights and flights with each fault, and monitor them.

    Args:
        cell: Spacecraft, orbit, pointing and friction noise.
        plan: Size of the rehearsal, and the telemetry.
        assumptions: What is assumed beside the files.
        say: Receives each message for the user.
        opener: Opens an executor, whose jobs are the flights of a fault; None for this process.
    """
    say(f"flying {plan.flights} healthy flights of {plan.days} days")
    healthy = _Batch(cell, [Flight(n) for n in range(plan.flights)], plan.days, plan)
    ((table, healths),) = mapped(_flown, [healthy], opener)
    flights_of = {
        name: [_faulty(kind, n, cell.vehicle.count) for n in range(plan.flights)]
        for name, kind in FAULTS.items()
        # a wheel that never stops does not show stiction
        if name != "stiction" or np.any(table["crossings"] > 0.0)
    }
    say(f"flying {plan.flights} flights with each of {', '.join(flights_of)}")
    days = int(ONSET) + 5 + AFTER
    batches = [_Batch(cell, flights, days, plan) for flights in flights_of.values()]
    expected = {}
    results = mapped(_flown, batches, opener)
    for (name, flights), (_, faulty) in zip(flights_of.items(), results, strict=True):
        onsets = {
            f"{flight.number}/wheel{fault.wheel + 1}": int(fault.day)
            for flight in flights
            for fault in flight.faults
        }
        expected[name] = _expected(name, FAULTS[name].usual_size, onsets, faulty)
    good = table["valid"]
    return Rehearsal(
        len(table) / YEAR,
        sum(len(health.alarms) for health in healths),
        {
            name: float(
                np.nanmedian(
                    table[f"{name}_sigma"][good]
                    / np.abs(table["coulomb" if name == "offset" else name][good])
                )
            )
            if np.any(good)
            else float("nan")
            for name in REGRESSED
        },
        {name: float(np.mean(table[f"{name}_observable"])) for name in REGRESSED},
        expected,
        assumptions,
    )


def _faulty(kind: type[Fault], number: int, wheels: int) -> Flight:
    """Flight with the fault in each wheel; a seizure, which costs the attitude, in one."""
    random = np.random.default_rng([number, 23])
    days = ONSET + 5.0 * random.uniform(0.0, 1.0, wheels)
    struck = [number % wheels] if kind.name == "seizure" else range(wheels)
    size, duration = kind.usual_size, kind.usual_duration
    faults = [kind(k, float(days[k]), size, duration, 10 * number + k) for k in struck]
    return Flight(1000 + number, tuple(faults))


class _Batch(NamedTuple):
    """Flights that are simulated together."""

    cell: Cell
    flights: list[Flight]
    days: int
    plan: Plan


def _flown(batch: _Batch) -> tuple[Windows, list[WheelHealth]]:
    """Window table and health of all wheels of a batch; a wheel is called FLIGHT/NAME."""
    cell, flights, days, plan = batch
    known = known_wheels(cell.vehicle, plan.sampling)
    monitors = [WheelMonitor(known) for _ in flights]
    for flown in Fleet(cell, flights).days(days):
        for day, monitor in zip(flown, monitors, strict=True):
            columns = sample(day, cell.vehicle, plan.sampling)
            monitor.add(samples_of(columns, cell.vehicle))
    tables, references = [], {}
    for flight, monitor in zip(flights, monitors, strict=True):
        table = monitor.windows()
        table["wheel"][:] = [f"{flight.number}/{name}" for name in table["wheel"]]
        tables.append(table)
        references |= {f"{flight.number}/{w.name}": reference_to(w) for w in known.wheels}
    joined = Windows.joined(tables)
    return joined, assess(joined, plan.settings, references)


def _expected(
    name: str, size: float, onsets: Mapping[str, int], healths: list[WheelHealth]
) -> Expected:
    delays, right, among = [], 0, 0
    for health in healths:
        if health.wheel not in onsets:
            continue
        onset = onsets[health.wheel]
        late = [k for k, verdict in enumerate(health.verdicts) if verdict.alarm and k >= onset]
        delays.append(float(late[0] - onset) if late else np.inf)
        if late and name in health.verdicts[-1].classes:
            right += len(health.verdicts[-1].classes) == 1
            among += len(health.verdicts[-1].classes) > 1
    alarms = int(np.sum(np.isfinite(delays)))
    return Expected(size, len(delays), alarms, float(np.median(delays)), right, among)


def samples_of(
    columns: Mapping[str, NDArray[Any]], vehicle: Vehicle, drive: str = "current"
) -> Samples:
    """Columns of a fleet's telemetry as the monitor takes them.

    Args:
        columns: Columns of `fleet.sampling.sample`.
        vehicle: Spacecraft.
        drive: "current" or "torque"; "power" with the nominal idle power.
    """

    def per_wheel(name: str) -> NDArray[np.float64]:
        wheels = range(1, vehicle.count + 1)
        return np.stack([columns[f"wheel{k}_{name}"] for k in wheels], axis=1).astype(float)

    speed = per_wheel("speed_rpm") * RPM
    if drive == "torque":
        driven = per_wheel("torque_N·m") / vehicle.wheel.motor_constant
    elif drive == "power":
        known = known_wheels(vehicle, Sampling())
        driven = current_of_power(per_wheel("power_W"), speed, known)
    else:
        driven = per_wheel("current_A")
    return Samples(
        columns["time_s"],
        speed,
        driven,
        np.stack([columns[f"rate_{k}_rad/s"] for k in "xyz"], axis=1),
        np.repeat(columns["temperature_degC"][:, None], vehicle.count, axis=1),
        columns["mode"].astype(float),
    )
