"""Motor electronics: lag, limits, quantisation, back-EMF."""

from typing import Annotated

import numpy as np

from gyrostat.core.arrays import Scalar
from gyrostat.core.checked import Checked, Rule, within
from gyrostat.core.errors import InputError
from gyrostat.core.jax64 import jnp

SETTLED = 40.0
"""Time constants after which exp(-t/tau) is below rounding."""
LAG_STEP = 0.1
"""Share of its time constant in which a lag that has just begun is resolved."""


def _size(name: str) -> Rule:
    return within(f"driver {name}", "0 or more", lambda value: value >= 0.0)


class Driver(Checked):
    """A current loop: limits and quantisation once a control period, then a first-order lag.

    The current that the supply allows falls with speed: V = R I + k_m w, with the back-EMF constant
    equal to the motor constant in SI. It is taken at the start of a control period.

    Attributes:
        time_constant: of the current loop, s; zero for none.
        current_limit: A.
        torque_limit: of the motor, N·m.
        current_quantum: step of the commanded current, A; zero for none.
        bus_voltage: V.
        resistance: of the winding, Ω.
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
            InputError: A finite bus voltage without a resistance.
        """
        limited = np.isfinite(np.asarray(self.bus_voltage))
        if np.any(limited & (np.asarray(self.resistance) == 0.0)):
            raise InputError(
                "driver resistance: found 0 Ω, expected more: the bus voltage limits the current "
                "through it"
            )

    def set_point(self, command: Scalar, speed: Scalar, motor_constant: Scalar) -> Scalar:
        """The current that the loop goes to, A, within its limits and on its steps.

        Args:
            command: A.
            speed: of the wheel, rad/s.
            motor_constant: N·m/A.
        """
        # no limit on the torque must not become one by division: its derivative would be NaN
        endless = jnp.isinf(self.torque_limit)
        torque_limit = jnp.where(endless, 0.0, self.torque_limit) / jnp.abs(motor_constant)
        limit = jnp.minimum(self.current_limit, jnp.where(endless, jnp.inf, torque_limit))
        sense = jnp.sign(command)
        supply = self.bus_voltage - sense * motor_constant * speed
        unlimited = jnp.isinf(self.bus_voltage)
        ahead = supply / jnp.where(unlimited, 1.0, self.resistance)
        limit = jnp.minimum(limit, jnp.where(unlimited, jnp.inf, jnp.maximum(ahead, 0.0)))
        quantised = self.current_quantum > 0.0
        quantum = jnp.where(quantised, self.current_quantum, 1.0)
        size = jnp.abs(command)
        size = jnp.where(quantised, quantum * jnp.round(size / quantum), size)
        # the largest step that is still within the limit, also where rounding leaves 2.9999 of 3
        whole = jnp.where(
            quantised & jnp.isfinite(limit),
            quantum
            * jnp.floor(jnp.where(jnp.isfinite(limit), limit, 0.0) / quantum * (1.0 + 1e-12)),
            limit,
        )
        return sense * jnp.minimum(size, whole)

    def limited(self, command: Scalar, set_point: Scalar) -> Scalar:
        """Whether a limit, rather than the quantisation, kept the current from its command."""
        return jnp.abs(command) - jnp.abs(set_point) > 0.5 * self.current_quantum * (1.0 + 1e-9)

    def current(self, start: Scalar, set_point: Scalar, time: Scalar) -> Scalar:
        """Current of the lag, A, a time after its start.

        Args:
            start: current then, A.
            set_point: A.
            time: s.
        """
        lags = self.time_constant > 0.0
        decay = jnp.exp(-time / jnp.where(lags, self.time_constant, 1.0))
        return set_point + jnp.where(lags, start - set_point, 0.0) * decay

    def mean_current(self, start: Scalar, set_point: Scalar, duration: Scalar) -> Scalar:
        """Mean of `current` over a time from its start, A.

        Args:
            start: current then, A.
            set_point: A.
            duration: s; 0 for the current at the start.
        """
        lags = self.time_constant > 0.0
        constants = duration / jnp.where(lags, self.time_constant, 1.0)
        some = jnp.where(constants > 0.0, constants, 1.0)
        share = jnp.where(constants > 0.0, -jnp.expm1(-some) / some, 1.0)
        return set_point + jnp.where(lags, start - set_point, 0.0) * share

    def longest_segment(self, time: Scalar) -> Scalar:
        """Longest integration step that resolves the lag a time after its start, s."""
        lags = self.time_constant > 0.0
        tau = jnp.where(lags, self.time_constant, 1.0)
        # the error of a fourth-order step falls with the fifth root of what is left of the lag
        step = LAG_STEP * tau * jnp.exp(jnp.minimum(time / (5.0 * tau), SETTLED))
        return jnp.where(lags & (time < SETTLED * tau), step, jnp.inf)

    def power(self, current: Scalar, speed: Scalar, motor_constant: Scalar) -> Scalar:
        """Electrical power drawn, W; negative while the motor brakes and feeds back.

        Args:
            current: A.
            speed: rad/s.
            motor_constant: N·m/A.
        """
        return self.resistance * current**2 + motor_constant * current * speed
