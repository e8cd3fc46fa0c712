"""The numbers that the paper prints, and the wheels that they describe."""

from dataclasses import dataclass

from gyrostat.friction import Stribeck
from gyrostat.units import RPM
from gyrostat.wheel import Wheel

NAME = "carrara-kuga"
CITATION = (
    "V. Carrara and H. K. Kuga, Estimating friction parameters in reaction wheels for attitude "
    "control"
)
INERTIA = 1.5e-3
"""J_w, kg·m², from the manufacturer of the wheel."""
STRIBECK_SPEED = 4.0 * RPM
"""w_s, rad/s: the 4 rpm that the paper holds."""
SPEED_SIGMA = 5.0 * RPM
"""Noise of the tachometer, rad/s: the 5 rpm that the paper assumes."""
DURATION = 300.0
"""Of each profile, s."""

NAMES = ("motor_constant", "viscous", "coulomb", "static")
"""k_m, b, c and T_s: the parameters x2..x5 times J_w."""
UNITS = ("N·m/A", "N·m·s/rad", "N·m", "N·m")
START = (18.0, 0.00344, 0.5863, 0.0)
"""Eq. (15), x2..x5: the start, in rad/s²/A, 1/s, rad/s² and rad/s²."""
CONVERGED = (15.205, 0.00322, 0.5863, 0.6037)
"""Eq. (16), x2..x5: the end of the iteration, in the units of `START`."""


@dataclass(frozen=True)
class Column:
    """One column of Table 1.

    Attributes:
        motor_constant: k_m, N·m/A.
        viscous: b, N·m·s/rad.
        coulomb: c, N·m.
        static: T_s, N·m.
    """

    motor_constant: float
    viscous: float
    coulomb: float
    static: float

    def friction(self) -> Stribeck:
        """The friction with these parameters."""
        return Stribeck(
            viscous=self.viscous,
            coulomb=self.coulomb,
            static=self.static,
            stribeck_speed=STRIBECK_SPEED,
        )

    def wheel(self) -> Wheel:
        """The wheel with these parameters."""
        return Wheel(inertia=INERTIA, motor_constant=self.motor_constant, friction=self.friction())


DETERMINISTIC = Column(0.0270, 5.16e-6, 0.8795e-3, 0.8795e-3)
"""Table 1, left. It gives no static torque: without a Stribeck term T_s = c."""
STATISTICAL = Column(0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3)
"""Table 1, right: the truth of every virtual record here."""
