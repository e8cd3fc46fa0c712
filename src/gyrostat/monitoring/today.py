"""Wheels of today: the model file of each wheel from its last valid window."""

import numpy as np

from gyrostat.monitoring.health import Health, covariance
from gyrostat.monitoring.wheel_data import KnownWheels
from gyrostat.wheel.friction import ViscousCoulomb
from gyrostat.wheel.model_file import KNOWN_BEFOREHAND, WheelModel

_NAMES = ("coulomb", "viscous", "motor_constant")


def wheel_models(health: Health, known: KnownWheels) -> dict[str, WheelModel]:
    """Model of each wheel whose Coulomb torque is observable in its last valid window.

    A parameter that is not observable there has the value and uncertainty known beforehand; so has
    the motor constant if the drive is the electrical power, which does not show it.

    Args:
        health: Result of monitoring.
        known: What is known of the wheels beforehand.
    """
    models = {}
    for wheel in known.wheels:
        row = health.latest(wheel.name)
        if row is None or not row["coulomb_observable"] or row["viscous"] < 0.0:
            continue
        names = _NAMES[:-1] if health.telemetry["drive"] == "power" else _NAMES
        matrix = covariance(row, names)
        sigma = np.sqrt(np.diagonal(matrix))
        before = {"inertia": wheel.inertia, "motor_constant": wheel.motor_constant}
        motor = {"motor_constant": wheel.sigma_of("motor_constant")}
        origin = {
            "method": "monitor",
            "window": f"{row['start']:.0f} s to {row['end']:.0f} s of the telemetry",
        }
        unknown = {*before, *names} - {n for n in names if row[f"{n}_observable"]}
        origin[KNOWN_BEFOREHAND] = ", ".join(sorted(unknown))
        if np.isfinite(row["temperature_mean"]):
            origin["temperature"] = f"{row['temperature_mean']:.4g} °C"
        models[wheel.name] = WheelModel(
            friction=ViscousCoulomb,
            values=before | {name: float(row[name]) for name in names},
            sigma=motor | dict(zip(names, map(float, sigma), strict=True)),
            correlation=(names, matrix / np.outer(sigma, sigma)),
            origin=origin,
        )
    return models
