"""Parameters printed in the paper, our choices where it prints none, and the wheels."""

from dataclasses import dataclass
from typing import Any

from gyrostat.control import AttitudePID
from gyrostat.core.jax64 import jnp
from gyrostat.core.units import RPM
from gyrostat.simulation import CurrentRange
from gyrostat.spacecraft import AirBearingTable
from gyrostat.wheel import Wheel
from gyrostat.wheel.friction import Stribeck

INERTIA = 1.5e-3
"""Wheel inertia J_w, from the manufacturer, kg·m²."""
STRIBECK_SPEED = 4.0 * RPM
"""Stribeck speed w_s, rad/s: 4 rpm, held in the paper."""
SPEED_SIGMA = 5.0 * RPM
"""Noise of the tachometer, rad/s: 5 rpm, assumed in the paper."""
DURATION = 300.0
"""Duration of each profile, s."""
NAMES = ("motor_constant", "viscous", "coulomb", "static")
"""Names of k_m, b, c and T_s, which are the parameters x2..x5 times J_w."""
START = (18.0, 0.00344, 0.5863, 0.0)
"""Eq. (15), x2..x5: start values, in rad/s²/A, 1/s, rad/s² and rad/s²."""
CONVERGED = (15.205, 0.00322, 0.5863, 0.6037)
"""Eq. (16), x2..x5: converged values, in the units of `START`."""

RATE = 10.0
"""Sampling rate, chosen here, Hz."""
STEP_CURRENTS, STEP_PERIOD = CurrentRange(0.06, 0.15), 30.0
"""Profile 2: amplitudes, chosen, A; duration of a step, from the paper, s."""
SINE_CURRENTS, SINE_PERIOD = CurrentRange(0.08, 0.20), 24.0
"""Profile 1, chosen: amplitudes, A; mean period, 12.5 cycles in 300 s, s."""
PRIOR_SIGMA = (5.0, 0.002, 0.3, 0.6)
"""A-priori sigmas of x2..x5 about eq. (15), chosen here, in the units of `START`."""


@dataclass(frozen=True)
class Column:
    """One column of Table 1.

    Attributes:
        motor_constant: Motor constant k_m, N·m/A.
        viscous: Viscous coefficient b, N·m·s/rad.
        coulomb: Coulomb torque c, N·m.
        static: Static torque T_s, N·m.
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
"""Table 1, left. It gives no static torque; without Stribeck effect T_s = c."""
STATISTICAL = Column(0.0228, 4.83e-6, 0.8795e-3, 0.9055e-3)
"""Table 1, right: true parameters of every virtual record."""

TABLE_INERTIA = 0.495
"""Inertia J of the table, chosen here, kg·m²."""
FAN_TORQUE = 0.46e-3
"""External torque T_d, estimated in the paper, N·m."""
INITIAL_SPEED = -673.5 * RPM
"""Initial wheel speed, chosen so that the crossing occurs at 230 s as in the paper, rad/s."""
PERIOD = 0.1
"""Control period, chosen here, s."""
LAW = AttitudePID(proportional=0.0571, integral=0.00234, derivative=0.3126)
"""PID law, chosen to give the paper's peak of 1.5 deg."""
WHEEL = STATISTICAL.wheel()
TABLE = AirBearingTable(TABLE_INERTIA, WHEEL, external_torque=FAN_TORQUE)
STILL_TABLE = AirBearingTable(TABLE_INERTIA, WHEEL)
"""Table without fan."""


def scaled(coulomb: Any, static: Any = 1.0, viscous: Any = 1.0) -> Stribeck:
    """Friction of the wheel with some of its parameters multiplied by factors."""
    return Stribeck(
        viscous=STATISTICAL.viscous * viscous,
        coulomb=STATISTICAL.coulomb * coulomb,
        static=STATISTICAL.static * static,
        stribeck_speed=STRIBECK_SPEED * jnp.ones_like(coulomb),
    )
