"""Spacecraft of a fleet: rigid body, equal wheels, attitude loop, sensors."""

from dataclasses import dataclass, field

import numpy as np

from gyrostat.core.types import Matrix, Vector


def pyramid(elevation: float = np.arctan(np.sqrt(0.5))) -> Matrix:
    """Axes of four wheels in a pyramid about body z, (3, 4).

    Args:
        elevation: Angle between the axes and the body's x-y plane, rad; by default the one that
            gives equal momentum about all body axes.
    """
    azimuth = np.pi / 4.0 + np.pi / 2.0 * np.arange(4)
    return np.stack(
        [
            np.cos(elevation) * np.cos(azimuth),
            np.cos(elevation) * np.sin(azimuth),
            np.full(4, np.sin(elevation)),
        ]
    )


@dataclass(frozen=True)
class FleetWheel:
    """Nominal wheel of a fleet, and the scatter of its wheels.

    Attributes:
        inertia: Rotor inertia, kg·m².
        motor_constant: N·m/A.
        coulomb: Coulomb torque, N·m.
        viscous: Viscous coefficient at 20 °C, N·m·s/rad.
        static: Breakaway torque, N·m.
        stribeck_speed: rad/s.
        torque_limit: Largest motor torque, N·m.
        viscous_temperature: Relative decrease of the viscous coefficient, 1/K.
        coulomb_temperature: Relative decrease of the Coulomb torque, 1/K.
        friction_scatter: Standard deviation of log Coulomb torque and log viscous coefficient.
        motor_scatter: Standard deviation of the relative motor constant.
        offset_scatter: Standard deviation of the offset torque, as a share of the Coulomb torque.
        idle_power: Electrical power of the drive at no current, W.
        resistance: Of winding and drive, Ohm.
    """

    inertia: float
    motor_constant: float
    coulomb: float
    viscous: float
    static: float
    stribeck_speed: float
    torque_limit: float
    viscous_temperature: float = 0.02
    coulomb_temperature: float = 0.001
    friction_scatter: float = 0.15
    motor_scatter: float = 0.01
    offset_scatter: float = 0.02
    idle_power: float = 1.0
    resistance: float = 1.0


@dataclass(frozen=True, eq=False)
class Vehicle:
    """Spacecraft of a fleet.

    Attributes:
        name: Name.
        inertia: Principal moments of inertia with the rotors held, (3,), kg·m².
        wheel: Nominal wheel.
        axes: Axes of the wheels, (3, wheels), three or four.
        bias_speed: Wheel speed that the null-space loop holds, alternating in sign, rad/s.
        largest_swing: Wheel speed about the bias at which momentum is unloaded, rad/s.
        bandwidth: Natural frequency of the attitude loop, rad/s.
        damping: Its damping ratio.
        slew_time: Duration of a slew, s.
        null_time: Time constant of the null-space loop, s.
        control_period: s.
        attitude_sigma: Noise of the measured attitude, rad per axis and sample.
        rate_sigma: Noise of the measured body rate, rad/s.
        current_sigma: Noise of the measured motor current, A.
        constant_torque: Constant disturbance in body axes, (3,), N·m.
    """

    name: str
    inertia: Vector
    wheel: FleetWheel
    bias_speed: float
    largest_swing: float
    bandwidth: float
    attitude_sigma: float
    rate_sigma: float
    constant_torque: Vector
    current_sigma: float = 5e-4
    axes: Matrix = field(default_factory=pyramid)
    damping: float = 0.8
    slew_time: float = 600.0
    null_time: float = 20.0
    control_period: float = 0.125

    @property
    def spread(self) -> Matrix:
        """Pseudo-inverse of the axes, (wheels, 3)."""
        return np.asarray(np.linalg.pinv(self.axes), dtype=float)

    @property
    def count(self) -> int:
        """Number of wheels."""
        return self.axes.shape[1]

    @property
    def null(self) -> Vector:
        """Unit vector of wheel torques that leave the body alone, (wheels,); 0 for three."""
        if self.count == 3:
            return np.zeros(3)
        direction = np.linalg.svd(self.axes)[2][-1]
        return direction * np.sign(direction[0])


LARGE = Vehicle(
    "300 kg",
    inertia=np.array([80.0, 70.0, 60.0]),
    wheel=FleetWheel(
        inertia=1.5e-3,
        motor_constant=0.027,
        coulomb=0.9e-3,
        viscous=5e-6,
        static=1.1e-3,
        stribeck_speed=0.5,
        torque_limit=0.05,
    ),
    bias_speed=150.0,
    largest_swing=60.0,
    bandwidth=0.12,
    attitude_sigma=5e-6,
    rate_sigma=2e-6,
    constant_torque=np.array([1.0e-5, -0.6e-5, 0.8e-5]),
)
"""Spacecraft of the 300 kg class."""

SMALL = Vehicle(
    "6 kg",
    inertia=np.array([0.065, 0.05, 0.025]),
    wheel=FleetWheel(
        inertia=1.5e-5,
        motor_constant=4e-3,
        coulomb=6e-5,
        viscous=1.5e-7,
        static=8e-5,
        stribeck_speed=1.0,
        torque_limit=2e-3,
        idle_power=0.1,
        resistance=3.0,
    ),
    bias_speed=200.0,
    largest_swing=80.0,
    bandwidth=0.5,
    attitude_sigma=5e-5,
    rate_sigma=5e-5,
    constant_torque=np.array([2e-8, -1.2e-8, 1.6e-8]),
    null_time=4.0,
    slew_time=120.0,
)
"""Spacecraft of the 6 kg class."""
