"""Telemetry of a flight's day: rounded, with gaps, repeated rows, resets and steps of the clock."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gyrostat.core.types import Vector
from gyrostat.monitoring.fleet.flight import DAY, FlightDay
from gyrostat.monitoring.fleet.pointing import product
from gyrostat.monitoring.fleet.vehicle import Vehicle

RPM = 2.0 * np.pi / 60.0
GAP = 900.0
"""Mean duration of a gap, s."""


@dataclass(frozen=True)
class Sampling:
    """Telemetry chain.

    Attributes:
        period: Time between rows, s.
        speed_step: Rounding of the wheel speeds, rad/s.
        current_step: Rounding of the motor currents, A.
        power_step: Rounding of the electrical powers, W.
        returned: Share of the power of a braking motor that its drive returns; negative for a drive
            that brakes with power of the supply.
        temperature_step: Rounding of the temperature, K.
        gap_share: Share of the time in gaps.
        repeat_share: Share of rows that arrive twice.
        resets: Resets of the computer per day: a gap of 1 to 10 minutes, and a step of the clock.
        clock_jumps: Steps of the clock per day, with a standard deviation of 2 s.
    """

    period: float = 1.0
    speed_step: float = 0.4 * RPM
    current_step: float = 1e-3
    power_step: float = 1e-3
    returned: float = 1.0
    temperature_step: float = 0.5
    gap_share: float = 0.0
    repeat_share: float = 0.0
    resets: float = 0.0
    clock_jumps: float = 0.0


UGLY = Sampling(gap_share=0.2, repeat_share=0.01, resets=1.0, clock_jumps=1.0)
"""A fifth of the telemetry lost, with a reset and a step of the clock a day."""
MODES = ("nadir", "slew", "unloading")
"""Mode of each number in the column `mode`."""


def sample(day: FlightDay, vehicle: Vehicle, sampling: Sampling) -> dict[str, NDArray]:
    """Telemetry of a day: name of a column, with its unit -> values, (N,).

    Columns: time, then for each wheel its speed, current, electrical power and commanded torque;
    body rate, attitude, commanded attitude, temperature and mode. The power is that at the measured
    speed, with the mean motor constant of the day.

    Args:
        day: Day of a flight.
        vehicle: Its spacecraft.
        sampling: Telemetry chain.
    """
    random = np.random.default_rng([day.flight.number, day.day, 5])
    step = day.time[1] - day.time[0]
    time = DAY * day.day + sampling.period * np.arange(round(DAY / sampling.period))
    at = (time - day.time[0]) / step
    before = np.minimum(np.floor(at + 1e-9).astype(int), day.time.size - 1)
    after = np.minimum(before + 1, day.time.size - 1)
    share = np.clip(at - before, 0.0, 1.0)[:, None]
    exact = bool(np.all(share < 1e-6))

    def between(values: NDArray) -> NDArray:
        if exact:
            return values[before]
        return values[before] + share * (values[after] - values[before])

    current = day.torque[before] / vehicle.wheel.motor_constant
    current = current + vehicle.current_sigma * random.standard_normal(current.shape, np.float32)
    angle, path = between(day.angle), day.commanded
    reference = between(path.rate)
    rate = reference - np.cross(angle, reference) + between(day.rate)
    target = between(path.quaternion)
    small = np.column_stack([np.ones(time.size), 0.5 * angle])
    attitude = product(target, small / np.linalg.norm(small, axis=1, keepdims=True))
    mode = np.where(day.firing[before], 2, path.slewing[before].astype(int))
    columns: dict[str, NDArray] = {"time_s": time}
    speed, wheel = between(day.speed), vehicle.wheel
    power = day.truth["motor_constant"] * speed * current + wheel.resistance * current**2
    power = wheel.idle_power + np.where(power > 0.0, power, sampling.returned * power)
    power = np.round(power / sampling.power_step) * sampling.power_step
    speed = np.round(speed / sampling.speed_step) * (sampling.speed_step / RPM)
    current = np.round(current / sampling.current_step) * sampling.current_step
    for k in range(vehicle.count):
        columns[f"wheel{k + 1}_speed_rpm"] = speed[:, k]
        columns[f"wheel{k + 1}_current_A"] = current[:, k]
        columns[f"wheel{k + 1}_power_W"] = power[:, k]
        columns[f"wheel{k + 1}_torque_N·m"] = day.torque[before, k]
    columns |= {f"rate_{name}_rad/s": rate[:, k] for k, name in enumerate("xyz")}
    columns |= {f"attitude_{name}": attitude[:, k] for k, name in enumerate("wxyz")}
    columns |= {f"commanded_{name}": target[:, k] for k, name in enumerate("wxyz")}
    warm = between(day.temperature[:, None])[:, 0] / sampling.temperature_step
    columns["temperature_degC"] = np.round(warm) * sampling.temperature_step
    columns["mode"] = mode.astype(np.int8)
    return _spoil(columns, sampling, random)


def _spoil(
    columns: dict[str, NDArray], sampling: Sampling, random: np.random.Generator
) -> dict[str, NDArray]:
    time = columns["time_s"]
    present = np.ones(time.shape, bool)
    clock = np.zeros(time.shape)
    begin = time[0]
    resets = begin + DAY * random.uniform(0.0, 1.0, random.poisson(sampling.resets))
    for at in resets:
        present &= (time < at) | (time > at + random.uniform(60.0, 600.0))
    jumps = begin + DAY * random.uniform(0.0, 1.0, random.poisson(sampling.clock_jumps))
    for at in (*resets, *jumps):
        clock[time >= at] += 2.0 * random.standard_normal()
    lost = random.poisson(sampling.gap_share * DAY / GAP) if sampling.gap_share else 0
    for at in begin + DAY * random.uniform(0.0, 1.0, lost):
        present &= (time < at) | (time > at + random.exponential(GAP))
    rows = np.flatnonzero(present)
    if sampling.repeat_share:
        twice = random.uniform(0.0, 1.0, rows.size) < sampling.repeat_share
        rows = np.sort(np.concatenate([rows, rows[twice]]))
    if rows.size == time.size and not clock.any():
        return columns
    spoiled = {name: values[rows] for name, values in columns.items()}
    spoiled["time_s"] = time[rows] + clock[rows]
    return spoiled


def gap_share_of(time: Vector, period: float) -> float:
    """Share of a day without rows.

    Args:
        time: Times of the rows, s.
        period: Time between rows, s.
    """
    return 1.0 - np.unique(time).size * period / DAY
