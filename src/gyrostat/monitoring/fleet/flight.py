"""Flights of a fleet: telemetry of years with known truth, day by day, in batches of flights."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.classes_of import classes_of
from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet import faults
from gyrostat.monitoring.fleet.attitude_loop import attitude_loop
from gyrostat.monitoring.fleet.dynamics import (
    NORMALS,
    Constants,
    advance,
    constants,
    start,
)
from gyrostat.monitoring.fleet.faults.fault import Fault
from gyrostat.monitoring.fleet.pointing import Motion, Orbit, Pointing, motion
from gyrostat.monitoring.fleet.states import Commanded, FlightState, Slow, Telemetered
from gyrostat.monitoring.fleet.vehicle import Vehicle

DAY = 86400.0
MINUTES = 60
"""Minutes that one call of the compiled dynamics flies."""
FAULTS: dict[str, type[Fault]] = {kind.name: kind for kind in classes_of(faults, Fault)}
"""Class of change -> its fault."""


@dataclass(frozen=True, eq=False)
class Cell:
    """Conditions of a fleet.

    Attributes:
        vehicle: Spacecraft.
        orbit: Orbit.
        pointing: Habits of pointing.
        noise_sigma: Standard deviation of the slow relative Coulomb noise.
        noise_time: Its correlation time, s.
        periods: Control periods per step of the dynamics.
        seed: Seed of the slews, common to the flights of a batch.
    """

    vehicle: Vehicle
    orbit: Orbit
    pointing: Pointing
    noise_sigma: float = 0.02
    noise_time: float = 1200.0
    periods: int = 8
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Flight:
    """One flight: a spacecraft with wheels of its own, and their faults.

    Attributes:
        number: Seed of the flight: its wheels, noise and telemetry.
        faults: Faults.
    """

    number: int
    faults: tuple[Fault, ...] = ()

    def wheels(self, cell: Cell) -> Mapping[str, Vector]:
        """True parameters of the wheels at the start, each (wheels,).

        Returns:
            coulomb, viscous, excess (breakaway beyond Coulomb), gain (relative deviation of the
            motor constant) and offset.
        """
        random = np.random.default_rng([self.number, 1])
        wheel, count = cell.vehicle.wheel, cell.vehicle.count
        scale = np.exp(wheel.friction_scatter * random.standard_normal((2, count)))
        return {
            "coulomb": wheel.coulomb * scale[0],
            "viscous": wheel.viscous * scale[1],
            "excess": np.full(count, wheel.static - wheel.coulomb),
            "gain": wheel.motor_scatter * random.standard_normal(count),
            "offset": wheel.offset_scatter * wheel.coulomb * random.standard_normal(count),
        }

    def slow(self, cell: Cell, time: Vector, temperature: Vector) -> list[dict[str, Vector]]:
        """Parameters over time for each wheel: field of `Slow` -> (N,).

        Args:
            cell: Conditions.
            time: Days, (N,).
            temperature: °C, (N,).
        """
        initial, wheel = self.wheels(cell), cell.vehicle.wheel
        warm = temperature - 20.0
        factors = {
            "coulomb": np.exp(-wheel.coulomb_temperature * warm),
            "viscous": np.exp(-wheel.viscous_temperature * warm),
        }
        rows = [
            {
                name: np.full(time.shape, initial[name][k] if name in initial else 0.0)
                * factors.get(name, 1.0)
                for name in Slow._fields
            }
            for k in range(cell.vehicle.count)
        ]
        for fault in self.faults:
            fault.apply(rows[fault.wheel], time, wheel)
        return rows


@dataclass(frozen=True, eq=False)
class FlightDay:
    """Telemetry before sampling errors and truth of one day of one flight.

    Attributes:
        flight: The flight.
        day: Number of the day.
        time: Times of the samples, (N,), s from the start of the flight.
        speed: Measured wheel speeds, (N, wheels), rad/s, neither quantised nor cut.
        torque: Commanded motor torques, (N, wheels), N·m.
        angle: Measured attitude error, (N, 3), rad.
        rate: Measured rate error, (N, 3), rad/s.
        coulomb: Realised Coulomb torque, (N, wheels), N·m.
        temperature: Of the wheels, (N,), °C.
        firing: Whether thrusters unload, (N,).
        commanded: Commanded motion.
        truth: Name -> mean over the day for each wheel, (wheels,): coulomb (realised),
            coulomb_level (without noise), viscous, static, motor_constant, offset, tachometer
            (relative error).
    """

    flight: Flight
    day: int
    time: Vector
    speed: NDArray[np.float32]
    torque: NDArray[np.float32]
    angle: NDArray[np.float32]
    rate: NDArray[np.float32]
    coulomb: NDArray[np.float32]
    temperature: Vector
    firing: NDArray[np.bool_]
    commanded: Motion
    truth: Mapping[str, Vector]


@dataclass(eq=False)
class Fleet:
    """Batch of flights under the same conditions that are flown side by side.

    The flights share the times and axes of slews; their wheels, noise and faults are their own and
    do not depend on the other flights of the batch.

    Attributes:
        cell: Conditions.
        flights: Flights.
        engine: "jax", "native" or "auto", see `dynamics.advance`.
    """

    cell: Cell
    flights: Sequence[Flight]
    engine: str = "auto"
    _numbers: Constants = field(init=False)

    def __post_init__(self):
        loop = attitude_loop(self.cell.vehicle, self.cell.periods)
        self._numbers = constants(
            self.cell.vehicle,
            loop,
            rods=self.cell.orbit.rods,
            bias_share=self.cell.pointing.bias_share,
            noise=(self.cell.noise_sigma, self.cell.noise_time),
        )

    def days(self, count: int) -> Iterator[list[FlightDay]]:
        """Fly from the start; one list of the flights' days for each day.

        Args:
            count: Number of days.
        """
        state = self._start()
        for day in range(count):
            state, flown = self._fly(day, state)
            yield flown

    def _start(self) -> FlightState:
        swing = self.cell.vehicle.wheel.inertia * self.cell.vehicle.largest_swing
        draws = [np.random.default_rng([f.number, 2]) for f in self.flights]
        momentum = np.stack([0.4 * swing * each.standard_normal(3) for each in draws])
        noise = self.cell.noise_sigma * np.stack(
            [each.standard_normal(self.cell.vehicle.count) for each in draws]
        )
        return start(len(self.flights), momentum, self._numbers, noise)

    def _fly(self, day: int, state: FlightState) -> tuple[FlightState, list[FlightDay]]:
        step = self._numbers.step
        steps = round(DAY / step)
        per_minute = round(60.0 / step)
        time = DAY * day + step * np.arange(steps)
        path = motion(
            self.cell.orbit,
            self.cell.pointing,
            self.cell.vehicle.slew_time,
            time,
            self.cell.seed,
        )
        commanded = self._commanded(path)
        minutes = time[::per_minute]
        temperature = self.cell.orbit.temperature(minutes)
        slow = [f.slow(self.cell, minutes / DAY, temperature) for f in self.flights]
        fields_of_slow = Slow(
            *(
                np.stack([[row[name] for row in rows] for rows in slow]).swapaxes(1, 2)
                for name in Slow._fields
            )
        )
        draws = [np.random.default_rng([f.number, day, 3]) for f in self.flights]
        parts: list[Telemetered] = []
        for first in range(0, minutes.size, MINUTES):
            count = min(MINUTES, minutes.size - first)
            size = (count * per_minute, NORMALS + self.cell.vehicle.count)
            normals = np.stack([d.standard_normal(size, np.float32) for d in draws])
            there = slice(first * per_minute, (first + count) * per_minute)
            state, samples = advance(
                self._numbers,
                state,
                Slow(*(each[:, first : first + count] for each in fields_of_slow)),
                Commanded(*(each[there] for each in commanded)),
                normals.astype(float),
                self.engine,
            )
            parts.append(Telemetered(*map(_small, samples)))
        whole = Telemetered(*(np.concatenate(each, axis=1) for each in zip(*parts, strict=True)))
        return state, self._split(day, time, path, slow, whole)

    def _commanded(self, path: Motion) -> Commanded:
        inertia, orbit = self.cell.vehicle.inertia, self.cell.orbit
        gradient = 3.0 * orbit.rate**2 * np.cross(path.nadir, inertia * path.nadir)
        return Commanded(path.to_inertial, path.rate, path.acceleration, gradient, path.field)

    def _split(
        self,
        day: int,
        time: Vector,
        path: Motion,
        slow: list[list[dict[str, Vector]]],
        samples: Telemetered,
    ) -> list[FlightDay]:
        temperature = self.cell.orbit.temperature(time)
        return [
            FlightDay(
                flight,
                day,
                time,
                samples.speed[b],
                samples.torque[b],
                samples.angle[b],
                samples.rate[b],
                samples.coulomb[b],
                temperature,
                samples.firing[b],
                path,
                self._truth(slow[b], samples.coulomb[b]),
            )
            for b, flight in enumerate(self.flights)
        ]

    def _truth(
        self, rows: list[dict[str, Vector]], coulomb: NDArray[np.float32]
    ) -> Mapping[str, Vector]:
        mean = {name: np.array([row[name].mean() for row in rows]) for name in Slow._fields}
        return {
            "coulomb": coulomb.mean(axis=0, dtype=float),
            "coulomb_level": mean["coulomb"],
            "viscous": mean["viscous"],
            "static": mean["coulomb"] + mean["excess"],
            "motor_constant": self.cell.vehicle.wheel.motor_constant * (1.0 + mean["gain"]),
            "offset": mean["offset"],
            "tachometer": mean["tachometer"],
        }


def _small(values: Any) -> Any:
    """Numbers in single precision."""
    return values if values.dtype == bool else values.astype(np.float32)
