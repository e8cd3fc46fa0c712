"""An independent wheel: scipy's DOP853 between events that are located on its dense output.

Nothing of the package is used. The friction is re-derived here; the Stribeck band is resolved by
limiting the step; at rest the wheel holds by the stick rule.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq

BAND = 6.0


@dataclass
class Reference:
    """J dw/dt = k_m I - F(w), with (b, c, T_s, w_s) for each sense of rotation."""

    inertia: float
    motor_constant: float
    positive: tuple[float, float, float, float]
    negative: tuple[float, float, float, float]
    zeros: list[float] = field(default_factory=list)
    """Times at which the turning wheel came to zero speed, in the last run."""

    @classmethod
    def symmetric(cls, inertia, motor_constant, viscous, coulomb, static, stribeck_speed):
        """The same friction in both senses."""
        friction = (viscous, coulomb, static, stribeck_speed)
        return cls(inertia, motor_constant, friction, friction)

    def friction(self, speed, sense):
        """b w + sgn(w) [c + (T_s - c) exp(-w²/w_s²)]."""
        viscous, coulomb, static, scale = self.positive if sense > 0 else self.negative
        excess = (static - coulomb) * np.exp(-((speed / scale) ** 2))
        return viscous * speed + sense * (coulomb + excess)

    def speeds(self, sampled, initial, knots, currents, hold="zero-order"):
        """Speeds at the times `sampled` of a wheel whose current is given at `knots`."""
        self.zeros = []
        speeds = np.full(len(sampled), float(initial))
        speed = float(initial)
        for k in range(len(knots) - 1):
            start, stop = knots[k], knots[k + 1]
            slope = (currents[k + 1] - currents[k]) / (stop - start) if hold == "linear" else 0.0
            inside = (sampled > start) & (sampled <= stop)
            speed, speeds[inside] = self._piece(
                start, stop, speed, currents[k], slope, sampled[inside]
            )
        return speeds

    def _piece(self, start, stop, speed, current, slope, sampled):
        """One straight line of current: end speed, speeds at the times `sampled`."""
        speeds = np.zeros(len(sampled))
        now, released = start, 0.0

        def torque(time):
            return self.motor_constant * (current + slope * (time - start))

        while now < stop:
            sense = released or np.sign(speed) or np.sign(torque(now))
            if speed == 0.0 and not released and self._holds(torque(now), sense):
                now, released = self._rest(now, stop, torque(now), self.motor_constant * slope)
                continue
            released, began = 0.0, now
            now, speed, turned = self._turn(now, stop, speed, sense, torque, slope, sampled)
            inside = (sampled > began) & (sampled <= now)
            speeds[inside] = turned[inside]
        return speed, speeds

    def _holds(self, torque, sense):
        return sense == 0.0 or abs(torque) <= self.friction(0.0, sense) * sense

    def _rest(self, now, stop, torque, climb):
        """End of the rest, and the sense of the breakaway (0: none)."""
        sense = np.sign(climb)
        if sense == 0.0:
            return stop, 0.0
        breakaway = now + (self.friction(0.0, sense) - torque) / climb
        return (breakaway, sense) if breakaway < stop else (stop, 0.0)

    def _turn(self, start, stop, speed, sense, torque, slope, sampled):
        """Turn in one sense up to `stop` or to zero: end time, end speed, speeds at `sampled`."""

        def rate(time, speed):
            return (torque(time) - self.friction(speed, sense)) / self.inertia

        scale = (self.positive if sense > 0 else self.negative)[3]
        ramp = abs(self.motor_constant * slope / self.inertia)
        solver = DOP853(
            lambda t, y: [rate(t, y[0])],
            start,
            [speed],
            stop,
            rtol=1e-13,
            atol=1e-15,
            first_step=min(1e-6, stop - start),
        )
        speeds = np.zeros(len(sampled))
        risen = speed != 0.0
        while solver.status == "running":
            reach = max(abs(solver.y[0]) - BAND * scale, 0.0) + 0.05 * scale
            fall = abs(rate(solver.t, solver.y[0]))
            limit = 2.0 * reach / (fall + np.sqrt(fall**2 + 2.0 * ramp * reach) + 1e-300)
            solver.max_step = min(limit, 0.25)
            solver.step()
            dense = solver.dense_output()
            inside = (sampled > solver.t_old) & (sampled <= solver.t)
            speeds[inside] = dense(sampled[inside])[0]
            zero, risen = _first_zero(dense, rate, solver.t_old, solver.t, sense, risen)
            if zero is not None:
                self.zeros.append(zero)
                speeds[sampled >= zero] = 0.0
                return zero, 0.0, speeds
        return stop, solver.y[0], speeds


def _first_zero(dense, rate, start, stop, sense, risen):
    """First time in a step at which the wheel, once risen from zero, is back at zero; and risen."""
    times = np.linspace(start, stop, 9)
    if rate(start, dense(start)[0]) * rate(stop, dense(stop)[0]) < 0.0:
        turn = brentq(lambda t: rate(t, dense(t)[0]), start, stop, xtol=1e-16, rtol=1e-15)
        times = np.sort(np.append(times, turn))
    heights = sense * dense(times)[0]
    for k in range(len(times)):
        if risen and k > 0 and heights[k] <= 0.0:
            return brentq(
                lambda t: dense(t)[0], times[k - 1], times[k], xtol=1e-16, rtol=1e-15
            ), risen
        risen = risen or heights[k] > 0.0
    return None, risen
