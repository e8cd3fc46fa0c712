"""An independent wheel on an air-bearing table: scipy's DOP853 between located events.

Nothing of the package is used. The equations are written for the table and for the rotor, each with
its own torques, rather than for the relative speed. Far from the Stribeck band, with a steady
current and a steady torque, they are linear and solved in closed form.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

FAR = 7.0
"""Stribeck speeds beyond which exp(-w²/w_s²) is below 1e-21."""
OPTIONS = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-16}


@dataclass
class TableReference:
    """J dΩ/dt = T_d - (k_m I - F), J_w (dw/dt + dΩ/dt) = k_m I - F, and a first-order lag of I."""

    inertia: float
    wheel_inertia: float
    motor_constant: float
    viscous: float
    coulomb: float
    static: float
    stribeck_speed: float
    torque: float | Callable[[float], float] = 0.0
    time_constant: float = 0.0

    def external(self, time):
        """T_d at a time."""
        return self.torque(time) if callable(self.torque) else self.torque

    def friction(self, speed, sense):
        """b w + sgn(w) [c + (T_s - c) exp(-w²/w_s²)]."""
        excess = (self.static - self.coulomb) * np.exp(-((speed / self.stribeck_speed) ** 2))
        return self.viscous * speed + sense * (self.coulomb + excess)

    def carry(self, state, set_point, start, duration):
        """(attitude, rate, speed, wheel angle, current) after a period of held set point."""
        attitude, rate, speed, angle, current = state
        tau = self.time_constant

        def motor(time):
            lag = (current - set_point) * np.exp(-(time - start) / tau) if tau > 0.0 else 0.0
            return self.motor_constant * (set_point + lag)

        body = np.array([attitude, rate, speed, angle])
        far = None
        if tau == 0.0 and not callable(self.torque):
            far = self._linear(body, motor(start), duration)
        if far is None:
            far = self._located(body, motor, start, start + duration)
        end = motor(start + duration) / self.motor_constant
        return (*far, end)

    def _linear(self, body, motor, duration):
        """Closed form far from the band on one side; None where the wheel is not there."""
        attitude, rate, speed, angle = body
        edge = FAR * self.stribeck_speed
        if abs(speed) <= edge:
            return None
        whole = self.inertia + self.wheel_inertia
        reduced = self.inertia * self.wheel_inertia / whole
        load = motor - self.wheel_inertia / whole * self.torque
        start = (load - np.sign(speed) * self.coulomb - self.viscous * speed) / reduced
        decay = self.viscous / reduced
        x = decay * duration
        gain = -np.expm1(-x) / x if x > 0.0 else 1.0
        twice = (x - 1.0 + np.exp(-x)) / x**2 if x > 1e-3 else 0.5 - x / 6.0 + x**2 / 24.0
        change = start * duration * gain
        if abs(speed + change) <= edge or speed * (speed + change) < 0.0:
            return None
        turned = speed * duration + start * duration**2 * twice
        impulse = self.torque * duration
        new_rate = rate + (impulse - self.wheel_inertia * change) / whole
        tipped = (
            rate * duration
            + (0.5 * impulse * duration - self.wheel_inertia * (turned - speed * duration)) / whole
        )
        return np.array([attitude + tipped, new_rate, speed + change, angle + turned])

    def _located(self, body, motor, now, stop):
        """The same through every event."""
        released = 0.0
        whole = self.inertia + self.wheel_inertia

        def load(time):
            return motor(time) - self.wheel_inertia / whole * self.external(time)

        while now < stop:
            speed = body[2]
            at_rest = speed == 0.0
            sense = released or np.sign(speed) or np.sign(load(now))
            if at_rest and not released and abs(load(now)) <= self.static:
                now, body, released = self._held(body, load, now, stop)
                continue
            now, body = self._turning(body, motor, sense, now, stop)
            released = 0.0
        return body

    def _held(self, body, load, now, stop):
        whole = self.inertia + self.wheel_inertia

        def breaks(time, y):
            return self.static - abs(load(time))

        breaks.terminal, breaks.direction = True, -1.0
        done = solve_ivp(
            lambda t, y: [y[1], self.external(t) / whole],
            (now, stop),
            body[:2],
            events=breaks,
            max_step=0.05,
            **OPTIONS,
        )
        body = np.array([*done.y[:, -1], 0.0, body[3]])
        time = done.t[-1]
        return time, body, np.sign(load(time)) if done.status == 1 else 0.0

    def _turning(self, body, motor, sense, now, stop):
        def rates(time, y):
            net = motor(time) - self.friction(y[2], sense)
            table = (self.external(time) - net) / self.inertia
            return [y[1], table, net / self.wheel_inertia - table, y[2]]

        def zero(time, y):
            return sense * y[2]

        zero.terminal, zero.direction = True, -1.0
        done = solve_ivp(rates, (now, stop), body, events=zero, max_step=0.05, **OPTIONS)
        body = done.y[:, -1].copy()
        if done.status == 1:
            body[2] = 0.0
        return done.t[-1], body
