"""What is known of the wheels of a spacecraft before their telemetry is read."""

from dataclasses import dataclass, field

import numpy as np

from gyrostat.core.pictured import Described
from gyrostat.core.types import Matrix, Vector

USUAL_SIGMA = {
    "motor_constant": 0.1,
    "viscous": 1.0,
    "warming": 0.05,
    "idle_power": 0.05,
    "resistance": 0.2,
}
"""Standard deviations over the nominal value where none is given; `warming` is that of the change
of the viscous coefficient with temperature, over the coefficient, 1/K."""
USUAL_GAIN = 0.1
"""Standard deviation of the relative error of a measured power where none is given."""
USUAL_OFFSET = 0.02
"""Standard deviation of the offset torque over the nominal Coulomb torque where none is given."""
VISCOUS_SPEED = 100.0
"""Speed at which viscous friction of one standard deviation is as large as the nominal Coulomb
torque, rad/s, where the nominal one is 0."""
REFERENCE_TEMPERATURE = 20.0
"""Temperature for which the viscous coefficient is known beforehand, °C."""


@dataclass(frozen=True)
class KnownWheel(Described):
    """Wheel as known beforehand.

    Attributes:
        name: Name.
        inertia: Rotor inertia, kg·m².
        motor_constant: N·m/A.
        coulomb: Nominal Coulomb torque, N·m.
        viscous: Nominal viscous coefficient at 20 °C, N·m·s/rad.
        offset: Offset torque, N·m.
        stribeck_speed: rad/s, or None if it is not known.
        sigma: Standard deviations of motor_constant, viscous, offset, idle_power, resistance and
            power_gain (of the relative error of the measured power), where they are known.
        idle_power: Electrical power of the drive at no current, W, or None if it is not known.
        resistance: Of winding and drive as the current sees it, Ohm, or None if it is not known.
    """

    name: str
    inertia: float
    motor_constant: float
    coulomb: float
    viscous: float
    offset: float = 0.0
    stribeck_speed: float | None = None
    sigma: dict[str, float] = field(default_factory=dict)
    idle_power: float | None = None
    resistance: float | None = None

    @property
    def slowest(self) -> float:
        """Speed above which the friction is Coulomb and viscous friction, rad/s."""
        return 5.0 * self.stribeck_speed if self.stribeck_speed else 10.0

    def sigma_of(self, name: str) -> float:
        """Standard deviation of a key of `sigma`, SI."""
        if name in self.sigma:
            return self.sigma[name]
        if name == "offset":
            return USUAL_OFFSET * self.coulomb
        if name == "power_gain":
            return USUAL_GAIN
        if name == "viscous" and self.viscous == 0.0:
            return self.coulomb / VISCOUS_SPEED
        return USUAL_SIGMA[name] * abs(getattr(self, name) or 0.0)


@dataclass(frozen=True, eq=False)
class KnownWheels:
    """Wheels of a spacecraft.

    Attributes:
        wheels: The wheels, in the order of the columns of the telemetry.
        axes: Spin axes in body axes, unit length, (3, wheels), or None if they are not known.
        inertia: Inertia of the body with the rotors' axial inertia left out, (3, 3), kg·m², or
            None.
        modes_left_out: Values of the mode column during which telemetry is not used.
        speed_resolution: Resolution of the speeds, rad/s; a wheel rests within half of it.
        power_resolution: Resolution of the electrical powers, W.
    """

    wheels: tuple[KnownWheel, ...]
    axes: Matrix | None = None
    inertia: Matrix | None = None
    modes_left_out: tuple[float, ...] = ()
    speed_resolution: float = 0.0
    power_resolution: float = 0.0

    @property
    def rotor_inertia(self) -> Vector:
        """Rotor inertias, (wheels,), kg·m²."""
        return np.array([wheel.inertia for wheel in self.wheels])

    def exchanged(self) -> Matrix:
        """Part of speeds whose momentum the body feels, as a matrix, (wheels, wheels).

        Friction also drives speeds that leave the momentum of the body as it is, and no attitude
        loop opposes this; such speeds are no instruments.
        """
        count = len(self.wheels)
        if self.axes is None:
            return np.eye(count)
        momentum = self.rotor_inertia
        return (np.linalg.pinv(self.axes) @ self.axes) * momentum / momentum[:, None]
