"""The air-bearing table of the paper, its controllers, and what is read from a run."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gyrostat._jax import jnp
from gyrostat._types import Vector
from gyrostat.body import AirBearingTable, TableSensors, TableState
from gyrostat.control import AttitudePID, CurrentMode, DynamicModelCompensator, SpeedMode
from gyrostat.friction import Friction, Stribeck
from gyrostat.papers.carrara_kuga.printed import STATISTICAL, STRIBECK_SPEED
from gyrostat.simulate import Batch, simulate
from gyrostat.units import RPM

TABLE_INERTIA = 0.495
"""J, kg·m²."""
FAN_TORQUE = 0.46e-3
"""T_d, N·m: the paper's estimate."""
INITIAL_SPEED = -673.5 * RPM
"""rad/s: the crossing falls at 230 s."""
PERIOD = 0.1
"""Control period, s."""
LAW = AttitudePID(proportional=0.0571, integral=0.00234, derivative=0.3126)
WHEEL = STATISTICAL.wheel()
TABLE = AirBearingTable(TABLE_INERTIA, WHEEL, external_torque=FAN_TORQUE)
STILL_TABLE = AirBearingTable(TABLE_INERTIA, WHEEL)
"""Without the fan."""
START = TABLE.start(speed=INITIAL_SPEED)

PID = CurrentMode(LAW, WHEEL.motor_constant)
SPEED_MODE = SpeedMode(LAW, WHEEL.inertia, WHEEL.motor_constant)


def scaled(coulomb: Any, static: Any = 1.0, viscous: Any = 1.0) -> Stribeck:
    """The wheel's friction with some of its parameters multiplied."""
    return Stribeck(
        viscous=STATISTICAL.viscous * viscous,
        coulomb=STATISTICAL.coulomb * coulomb,
        static=STATISTICAL.static * static,
        stribeck_speed=STRIBECK_SPEED * jnp.ones_like(coulomb),
    )


def compensator(friction: Friction) -> DynamicModelCompensator:
    """The paper's compensator with this friction model."""
    return DynamicModelCompensator(LAW, friction, WHEEL.motor_constant)


@dataclass(frozen=True)
class TableRun:
    """Runs of the table as arrays, first axis the run.

    Attributes:
        time: (N,) s.
        attitude: (runs, N) true, rad.
        measured: (runs, N) attitude from the gyro, rad.
        speed: (runs, N) of the wheel, rad/s.
        current: (runs, N) commanded, A.
        attitude_current: (runs, N) its part for the demanded torque, A.
        friction_current: (runs, N) its part for the friction, A.
        valid: (runs,) whether each run is complete.
    """

    time: Vector
    attitude: Vector
    measured: Vector
    speed: Vector
    current: Vector
    attitude_current: Vector
    friction_current: Vector
    valid: NDArray[np.bool_]

    def crossings(self) -> Vector:
        """Time of the first sample at which each wheel is no longer below zero, s."""
        return self.time[np.argmax(self.speed >= 0.0, axis=1)]

    def largest(self, signal: Vector, before: float, after: float) -> Vector:
        """Largest |signal| of each run from `before` to `after` its crossing, s."""
        crossing = self.crossings()[:, None]
        time = self.time[None]
        near = (time > crossing - before - 1e-6) & (time < crossing + after + 1e-6)
        return np.max(np.where(near, np.abs(signal), 0.0), axis=1)


def fly(
    controller: Any,
    duration: float,
    *,
    plant: AirBearingTable = TABLE,
    sensors: TableSensors | None = None,
    start: TableState | Batch = START,
    runs: int | None = None,
    seed: int = 0,
    command_delay: int = 0,
) -> TableRun:
    """Run the table in closed loop; see `gyrostat.simulate.simulate`."""
    histories = simulate(
        plant,
        controller,
        TableSensors() if sensors is None else sensors,
        start=start,
        duration=duration,
        control_period=PERIOD,
        command_delay=command_delay,
        runs=runs,
        seed=seed,
    )
    names = (
        "attitude",
        "measured_attitude",
        "speed",
        "commanded_current",
        "attitude_current",
        "friction_current",
    )
    signals = (np.atleast_2d(histories[name].values) for name in names)
    return TableRun(
        histories.time.values, *signals, valid=np.atleast_1d(histories.status.values == 0)
    )


def settled(controller: Any, **options: Any) -> TableRun:
    """700 s without external torque, wheel at rest, from an attitude of 0.5 deg."""
    return fly(
        controller,
        700.0,
        plant=STILL_TABLE,
        start=STILL_TABLE.start(attitude=np.radians(0.5)),
        **options,
    )


def wander(attitude: Vector, time: Vector) -> Vector:
    """Largest deviation of each run from its mean after the first 100 s, deg."""
    late = attitude[:, time > 100.0 - 1e-6]
    return np.degrees(np.max(np.abs(late - late.mean(axis=1, keepdims=True)), axis=1))
