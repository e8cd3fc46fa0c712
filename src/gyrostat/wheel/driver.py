"""Motor electronics: lag, limits, quantisation, back-EMF."""

from typing import Annotated

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, Rule, within
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp
from gyrostat.core.limiting import quantised

SETTLED = 40.0
"""Number of time constants after which exp(-t/tau) is below rounding."""
LAG_STEP = 0.1
"""Integration step at the start of a lag, over its time constant."""


def _size(name: str) -> Rule:
    return within(f"driver {name}", "0 or more", lambda value: value >= 0.0)


class Driver(Checked):
    """Motor driver with a current loop: limits and quantisation, then a first-order lag.

    Limits and quantisation are applied once per control period. The current that the supply voltage
    allows decreases with speed: V = R I + k_m w, with the back-EMF constant equal to the motor
    constant in SI units. The speed is taken at the start of a control period.

    Attributes:
        time_constant: Time constant of the current loop, s; zero for no lag.
        current_limit: Limit of the current, A.
        torque_limit: Limit of the motor torque, N·m.
        current_quantum: Quantum of the commanded current, A; zero for no quantisation.
        bus_voltage: Supply voltage, V.
        resistance: Winding resistance, Ω.
    """

    time_constant: Annotated[Scalar, _size("time_constant")] = 0.0
    current_limit: Annotated[Scalar, _size("current_limit")] = np.inf
    torque_limit: Annotated[Scalar, _size("torque_limit")] = np.inf
    current_quantum: Annotated[Scalar, _size("current_quantum")] = 0.0
    bus_voltage: Annotated[Scalar, _size("bus_voltage")] = np.inf
    resistance: Annotated[Scalar, _size("resistance")] = 0.0

    def check_own(self) -> None:
        """Validate the voltage limit.

        Raises:
            InputError: The bus voltage is finite but the resistance is zero.
        """
        limited = np.isfinite(np.asarray(self.bus_voltage))
        if np.any(limited & (np.asarray(self.resistance) == 0.0)):
            raise InputError(
                "driver resistance: found 0 Ω, expected more: the bus voltage limits the current "
                "through it"
            )

    def set_point(self, command: Scalar, speed: Scalar, motor_constant: Scalar) -> Scalar:
        """Set point of the current loop, A, after limits and quantisation.

        Args:
            command: Commanded current, A.
            speed: Wheel speed, rad/s.
            motor_constant: Motor constant, N·m/A.
        """
        # an infinite torque limit is not divided, since its derivative would be NaN
        endless = jnp.isinf(self.torque_limit)
        torque_limit = jnp.where(endless, 0.0, self.torque_limit) / jnp.abs(motor_constant)
        limit = jnp.minimum(self.current_limit, jnp.where(endless, jnp.inf, torque_limit))
        sense = jnp.sign(command)
        supply = self.bus_voltage - sense * motor_constant * speed
        unlimited = jnp.isinf(self.bus_voltage)
        ahead = supply / jnp.where(unlimited, 1.0, self.resistance)
        limit = jnp.minimum(limit, jnp.where(unlimited, jnp.inf, jnp.maximum(ahead, 0.0)))
        has_quantum = self.current_quantum > 0.0
        quantum = jnp.where(has_quantum, self.current_quantum, 1.0)
        size = quantised(jnp.abs(command), self.current_quantum)
        # largest multiple of the quantum within the limit, also if rounding gives 2.9999 for 3
        largest = jnp.where(
            has_quantum & jnp.isfinite(limit),
            quantum
            * jnp.floor(jnp.where(jnp.isfinite(limit), limit, 0.0) / quantum * (1.0 + 1e-12)),
            limit,
        )
        return sense * jnp.minimum(size, largest)

    def limited(self, command: Scalar, set_point: Scalar) -> Scalar:
        """Whether the set point differs from the command by a limit, not only by quantisation."""
        return jnp.abs(command) - jnp.abs(set_point) > 0.5 * self.current_quantum * (1.0 + 1e-9)

    def current(self, start: Scalar, set_point: Scalar, time: Scalar) -> Scalar:
        """Current after a time with a constant set point, A.

        Args:
            start: Current at the start, A.
            set_point: Set point of the current, A.
            time: Time since the start, s.
        """
        lags = self.time_constant > 0.0
        decay = jnp.exp(-time / jnp.where(lags, self.time_constant, 1.0))
        return set_point + jnp.where(lags, start - set_point, 0.0) * decay

    def mean_current(self, start: Scalar, set_point: Scalar, duration: Scalar) -> Scalar:
        """Mean of `current` over a time from the start, A.

        Args:
            start: Current at the start, A.
            set_point: Set point of the current, A.
            duration: Length of the time, s; 0 for the current at the start.
        """
        lags = self.time_constant > 0.0
        constants = duration / jnp.where(lags, self.time_constant, 1.0)
        nonzero = jnp.where(constants > 0.0, constants, 1.0)
        share = jnp.where(constants > 0.0, -jnp.expm1(-nonzero) / nonzero, 1.0)
        return set_point + jnp.where(lags, start - set_point, 0.0) * share

    def longest_segment(self, time: Scalar) -> Scalar:
        """Longest integration step that resolves the lag at a time after its start, s."""
        lags = self.time_constant > 0.0
        tau = jnp.where(lags, self.time_constant, 1.0)
        # for a constant error, a fourth-order step grows as the lag to the power of -1/5
        step = LAG_STEP * tau * jnp.exp(jnp.minimum(time / (5.0 * tau), SETTLED))
        return jnp.where(lags & (time < SETTLED * tau), step, jnp.inf)

    def power(self, current: Scalar, speed: Scalar, motor_constant: Scalar) -> Scalar:
        """Electrical power drawn, W; negative while the motor brakes and returns power.

        Args:
            current: Motor current, A.
            speed: Wheel speed, rad/s.
            motor_constant: Motor constant, N·m/A.
        """
        return self.resistance * current**2 + motor_constant * current * speed
