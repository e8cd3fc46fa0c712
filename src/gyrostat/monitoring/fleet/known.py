"""What the monitor may know of the wheels of a fleet: nominal values, and their scatter."""

import numpy as np

from gyrostat.monitoring.fleet.sampling import MODES, Sampling
from gyrostat.monitoring.fleet.vehicle import Vehicle
from gyrostat.monitoring.wheel_data import KnownWheel, KnownWheels


def known_wheels(vehicle: Vehicle, sampling: Sampling) -> KnownWheels:
    """Wheels of a vehicle as the monitor knows them beforehand.

    Args:
        vehicle: Spacecraft.
        sampling: Telemetry chain.
    """
    wheel = vehicle.wheel
    sigma = {
        "motor_constant": wheel.motor_scatter * wheel.motor_constant,
        # the friction scatters by a factor
        "viscous": 2.0 * wheel.friction_scatter * wheel.viscous,
        "offset": wheel.offset_scatter * wheel.coulomb,
    }
    electrical = {"idle_power": wheel.idle_power, "resistance": wheel.resistance}
    wheels = tuple(
        KnownWheel(
            f"wheel{k + 1}",
            wheel.inertia,
            wheel.motor_constant,
            wheel.coulomb,
            wheel.viscous,
            0.0,
            wheel.stribeck_speed,
            sigma,
            **electrical,
        )
        for k in range(vehicle.count)
    )
    modes = (float(MODES.index("unloading")),)
    inertia, steps = np.diag(vehicle.inertia), (sampling.speed_step, sampling.power_step)
    return KnownWheels(wheels, vehicle.axes, inertia, modes, *steps)
