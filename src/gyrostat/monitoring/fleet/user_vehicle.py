"""Vehicle of a fleet from the files of a user's spacecraft.

The files have inertia, axes, wheels and torque limits. The rest follows from rules that fit usual
spacecraft; `assumptions` names them for the user.
"""

import os
from pathlib import Path

import numpy as np

from gyrostat.core.errors import InputError
from gyrostat.monitoring.fleet.pointing import LOW
from gyrostat.monitoring.fleet.vehicle import FleetWheel, Vehicle
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.spacecraft.spacecraft_file import read_spacecraft

DROOP = 2e-3
"""Attitude error that the Coulomb torque of two wheels causes, rad."""
NOISE = 0.03
"""Torque of the rate noise, as a share of the Coulomb torque."""
BIAS = 0.35
"""Bias speed as a share of the largest wheel speed."""
STATIC = 1.25
"""Breakaway torque over the Coulomb torque."""


def user_vehicle(path: str | os.PathLike[str], known: KnownWheels) -> Vehicle:
    """Vehicle of a user.

    Args:
        path: Spacecraft file.
        known: What is known of its wheels; the first one stands for all.

    Raises:
        InputError: The file cannot be read, or has not three or four wheels.
    """
    content = read_spacecraft(Path(path))
    spacecraft = content.spacecraft
    axes = np.asarray(spacecraft.wheels.axes, dtype=float)
    if axes.shape[1] not in (3, 4) or np.linalg.matrix_rank(axes) < 3:
        raise InputError(
            f"{path}: key wheel: found {axes.shape[1]} wheels, expected three or four whose axes "
            "span all directions"
        )
    # the fleet flies in principal axes
    inertia, principal = np.linalg.eigh(np.asarray(spacecraft.inertia, dtype=float))
    nominal = known.wheels[0]
    limit = float(np.min(np.asarray(spacecraft.wheels.torque_limit)))
    momentum = float(np.min(np.asarray(spacecraft.wheels.momentum_limit)))
    speed = momentum / nominal.inertia if np.isfinite(momentum) else 430.0
    wheel = FleetWheel(
        nominal.inertia,
        nominal.motor_constant,
        nominal.coulomb,
        nominal.viscous,
        STATIC * nominal.coulomb,
        nominal.stribeck_speed or 0.5,
        limit if np.isfinite(limit) else 50.0 * nominal.coulomb,
    )
    return _completed(content.name or "spacecraft", inertia, principal.T @ axes, wheel, speed)


def _completed(
    name: str, inertia: np.ndarray, axes: np.ndarray, wheel: FleetWheel, speed: float
) -> Vehicle:
    mean, bias = float(np.mean(inertia)), BIAS * speed
    bandwidth = float(np.clip(np.sqrt(2.0 * wheel.coulomb / (np.min(inertia) * DROOP)), 0.05, 0.5))
    noise = NOISE * wheel.coulomb / (1.6 * bandwidth * mean)
    direction = np.array([0.7, -0.4, 0.6])
    return Vehicle(
        name,
        inertia=inertia,
        wheel=wheel,
        axes=axes,
        bias_speed=bias,
        largest_swing=0.4 * bias,
        bandwidth=bandwidth,
        attitude_sigma=noise,
        rate_sigma=noise,
        constant_torque=0.15 * LOW.rate**2 * mean * direction,
        null_time=float(np.clip(0.1 * wheel.inertia * bias / wheel.coulomb, 2.0, 60.0)),
        slew_time=float(max(120.0, 0.8 * mean / (0.4 * wheel.inertia * bias))),
    )


def assumptions(vehicle: Vehicle) -> tuple[str, ...]:
    """What the rehearsal assumes beside the files, one line each."""
    return (
        f"proportional-derivative attitude loop at {1.0 / vehicle.control_period:g} Hz, "
        f"{vehicle.bandwidth:.3g} rad/s, damping {vehicle.damping:g}",
        f"noise of attitude {vehicle.attitude_sigma:.2g} rad and rate {vehicle.rate_sigma:.2g} "
        "rad/s per sample",
        f"wheels held near {vehicle.bias_speed:.3g} rad/s"
        if vehicle.count == 4
        else "wheels that cross zero speed",
        f"slews of up to 40 deg in {vehicle.slew_time:.0f} s",
        f"scatter of friction {100.0 * vehicle.wheel.friction_scatter:.0f} %, of motor constant "
        f"{100.0 * vehicle.wheel.motor_scatter:.0f} %",
    )
