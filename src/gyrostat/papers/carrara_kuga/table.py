"""Air-bearing table: simulations under PID, dynamic model compensator and speed mode."""

from typing import TYPE_CHECKING, Any

import numpy as np

from gyrostat.control import CurrentMode, DynamicModelCompensator, SpeedMode
from gyrostat.core.jax64 import jax, jnp
from gyrostat.core.types import Vector
from gyrostat.papers.carrara_kuga import setup
from gyrostat.papers.carrara_kuga import table_figures as figures
from gyrostat.papers.claims import Value
from gyrostat.papers.reproduction import Part, Run
from gyrostat.simulation import Batch, simulate
from gyrostat.spacecraft import AirBearingTable, TableCommand, TableSensors, TableState
from gyrostat.wheel import Delayed, Tachometer
from gyrostat.wheel.friction import Friction

if TYPE_CHECKING:
    import xarray as xr

DURATION, LONG = 400.0, 640.0
"""Durations, s: time axis of the figures; 400 s after the crossing."""
SETTLED = 700.0
"""Duration of runs at rest, s, and of other runs of the compensator: one compiled program."""
SEEDS, QUICK_SEEDS = 200, 20
LATE_SAMPLES = 10
"""Delay of a late tachometer, samples: 1 s."""


def compensator(friction: Friction) -> DynamicModelCompensator:
    """The paper's compensator with a given friction model."""
    return DynamicModelCompensator(setup.LAW, friction, setup.WHEEL.motor_constant)


def fly(
    controller: Any,
    duration: float,
    *,
    plant: AirBearingTable = setup.TABLE,
    sensors: TableSensors | None = None,
    start: TableState | Batch | None = None,
    **options: Any,
) -> "xr.Dataset":
    """Simulate the table in closed loop; see `gyrostat.simulation.simulate`.

    Returns:
        Histories over `run` (also for a single run) and `time`.
    """
    histories = simulate(
        plant,
        controller,
        TableSensors() if sensors is None else sensors,
        start=setup.TABLE.start(speed=setup.INITIAL_SPEED) if start is None else start,
        duration=duration,
        control_period=setup.PERIOD,
        **options,
    )
    return histories if "run" in histories.dims else histories.expand_dims("run")


def crossings(flown: "xr.Dataset") -> Vector:
    """Time of the first sample with nonnegative wheel speed, for each run, s."""
    return flown.time.values[np.argmax(flown.speed.values >= 0.0, axis=1)]


def peaks(flown: "xr.Dataset", name: str = "attitude", before: float = 2.0) -> Vector:
    """Largest magnitude of an angle in each run until 60 s after its crossing, deg.

    Args:
        flown: Runs of the table.
        name: Name of the angle.
        before: Time before the crossing that counts, s.
    """
    time = flown.time.values[None] - crossings(flown)[:, None]
    near = (time > -before - 1e-6) & (time < 60.0 + 1e-6)
    return np.degrees(np.max(np.where(near, np.abs(flown[name].values), 0.0), axis=1))


def peak(flown: "xr.Dataset") -> float:
    """Largest attitude at the crossing, median of the runs, deg."""
    return float(np.median(peaks(flown)))


def start_transient(flown: "xr.Dataset") -> float:
    """Largest attitude of the first run's first 100 s, deg."""
    return float(np.degrees(np.max(np.abs(flown.attitude.values[0, flown.time < 100.05]))))


def error_after(flown: "xr.Dataset", wait: float) -> float:
    """Magnitude of the first run's attitude a time after its crossing, s; deg."""
    index = round(float(crossings(flown)[0] + wait) / setup.PERIOD)
    return float(np.degrees(abs(flown.attitude.values[0, index])))


def settled(controller: Any, **options: Any) -> "xr.Dataset":
    """Simulate `SETTLED` without external torque, wheel at rest, from an attitude of 0.5 deg."""
    start = setup.STILL_TABLE.start(attitude=np.radians(0.5))
    return fly(controller, SETTLED, plant=setup.STILL_TABLE, start=start, **options)


def wander(attitude: "xr.DataArray") -> Vector:
    """Largest deviation of each run from its mean after the first 100 s, deg."""
    late = attitude.values[:, attitude.time > 100.0 - 1e-6]
    return np.degrees(np.max(np.abs(late - late.mean(axis=1, keepdims=True)), axis=1))


def limit_cycle(friction: Friction) -> float:
    """Largest deviation from the mean attitude at rest, compensator with this friction, deg."""
    return float(wander(settled(compensator(friction)).attitude)[0])


def stick_time(flown: "xr.Dataset") -> float:
    """Time for which the wheel of a single run rests at its first crossing, s."""
    time, speed = flown.time.values, flown.speed.values[0]
    before = int(np.argmax(speed >= 0.0)) - 1
    release = int(np.argmax(speed > 0.0)) - 1
    current = float(flown.commanded_current.values[0, before])
    # the wheel's own motion over one period does not depend on attitude, rate or angle
    state = setup.TABLE.start(speed=speed[before])._replace(current=jnp.asarray(current))
    step = jax.jit(setup.TABLE.__call__)
    command = TableCommand(jnp.asarray(current))
    low, high = 0.0, setup.PERIOD
    for _ in range(40):
        middle = 0.5 * (low + high)
        landed = float(step(state, command, 0.0, middle)[0].speed) >= 0.0
        low, high = (low, middle) if landed else (middle, high)
    return float(time[release] - time[before] - high)


def crossing_zero(run: Run) -> Part:
    """The table crosses zero wheel speed under PID, compensator and speed mode."""
    run.say("simulating the zero crossing under PID, compensator and speed mode")
    exact_model, motor = compensator(setup.STATISTICAL.friction()), setup.WHEEL.motor_constant
    pid = fly(CurrentMode(setup.LAW, motor), LONG)
    speed_mode = fly(SpeedMode(setup.LAW, setup.WHEEL.inertia, motor), DURATION)
    exact = fly(exact_model, SETTLED)
    late = TableSensors(tachometer=Delayed(Tachometer(), LATE_SAMPLES))
    noisy = TableSensors(tachometer=Tachometer(setup.SPEED_SIGMA))
    seeds = QUICK_SEEDS if run.quick else SEEDS
    noise_peak = peak(fly(exact_model, DURATION, sensors=noisy, runs=seeds))
    minus5, plus5, plus10 = (
        peak(fly(compensator(setup.scaled(factor)), SETTLED)) for factor in (0.95, 1.05, 1.10)
    )
    values: dict[str, Value] = {
        "table.pid_peak_deg": peak(pid),
        "table.pid_error_60s_deg": error_after(pid, 60.0),
        "table.pid_error_final_deg": error_after(pid, 400.0),
        "table.pid_start_transient_deg": start_transient(pid),
        "table.stick_time_s": stick_time(pid),
        "table.dmc_peak_exact_deg": peak(exact),
        "table.dmc_peak_coulomb_minus5_deg": minus5,
        "table.dmc_peak_coulomb_plus5_deg": plus5,
        "table.dmc_peak_coulomb_plus10_deg": plus10,
        "table.dmc_start_transient_deg": start_transient(exact),
        "table.peak_ratio_coulomb5": peak(pid) / max(minus5, plus5),
        "table.dmc_peak_noise5rpm_deg": noise_peak,
        "table.dmc_peak_delay1s_deg": peak(fly(exact_model, DURATION, sensors=late)),
        "table.speed_mode_peak_deg": peak(speed_mode),
        "limit_cycle.overcompensated10_deg": limit_cycle(setup.scaled(1.1, 1.1)),
    }
    facts = {
        "seeds": seeds,
        "gain_in_noise": peak(pid) / noise_peak,
        "explaining_error": 0.1 / plus5 * 5.0,
        "ratio10": peak(pid) / plus10,
    }
    drawings = (
        figures.attitude("Attitude error under PID (Fig. 7)", pid, crossings(pid)[0]),
        figures.current("Motor current under PID (Fig. 8)", pid, parts=False),
        figures.attitude(
            "Attitude error with the compensator (Fig. 10)", exact, crossings(exact)[0]
        ),
        figures.current("Motor current with compensator (Fig. 11)", exact, parts=True),
        figures.attitude("Attitude error in speed mode", speed_mode, crossings(speed_mode)[0]),
    )
    return Part(values, facts, drawings)
