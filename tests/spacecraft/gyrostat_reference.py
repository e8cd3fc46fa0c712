"""A body with wheels in another formulation, by DOP853, with every event located: slow and plain.

State (q, w, W): Euler's equation for the body rate w and Newton's for each rotor, the wheels'
speeds W relative to the body. Wheels rest, turn and break away as separate modes of motion. A body
with vibration modes has their coordinates x and rates v behind, by Lagrange's equations.
"""

import numpy as np
from scipy.integrate import solve_ivp

TIGHT = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14}


class Reference:
    def __init__(self, inertia, axes, rotors, friction, external=(0.0, 0.0, 0.0), modes=None):
        """`modes`: participation (m, 3), and matrices of mass, damping and stiffness, (m, m)."""
        self.J, self.A, self.D = np.asarray(inertia), np.asarray(axes), np.asarray(rotors)
        self.viscous, self.coulomb, self.static, self.scale = friction
        self.external = np.asarray(external)
        nothing = np.zeros((0, 0))
        self.modes = (np.zeros((0, 3)), nothing, nothing, nothing) if modes is None else modes

    def sliding(self, speed, sense):
        level = self.coulomb + (self.static - self.coulomb) * np.exp(-((speed / self.scale) ** 2))
        return self.viscous * speed + sense * level

    def accelerations(self, y, sense, motor):
        """Accelerations of body and wheels, friction torques and modal accelerations.

        One linear system; unknowns: dw (3), dW (N), the friction or holding torque of each wheel,
        and dv (m).
        """
        n, (P, mass, damping, stiffness) = len(self.D), self.modes
        m = len(P)
        w, speed, x, v = y[4:7], y[7 : 7 + n], y[7 + n : 7 + n + m], y[7 + n + m :]
        h = self.D * (speed + self.A.T @ w)
        gyroscopic = self.external - np.cross(w, self.J @ w + self.A @ h + P.T @ v)
        held = sense == 0.0
        slides = np.where(held, 0.0, self.sliding(speed, sense))
        last = 3 + 2 * n
        M, right = np.zeros((last + m, last + m)), np.zeros(last + m)
        # J dw + A (m - F) + P' dv = N;  D (dW + A' dw) = m - F;  P dw + mass dv = -forces
        M[:3, :3] = self.J
        M[:3, 3 + n : last] = -self.A
        M[:3, last:] = P.T
        M[last:, :3] = P
        M[last:, last:] = mass
        right[last:] = -damping @ v - stiffness @ x
        right[:3] = gyroscopic - self.A @ motor
        M[3 : 3 + n, :3] = self.D[:, None] * self.A.T
        M[3 : 3 + n, 3 : 3 + n] = np.diag(self.D)
        M[3 : 3 + n, 3 + n : last] = np.eye(n)
        right[3 : 3 + n] = motor
        for k in range(n):
            row = 3 + n + k
            if held[k]:
                M[row, 3 + k] = 1.0
            else:
                M[row, row], right[row] = 1.0, slides[k]
        found = np.linalg.solve(M, right)
        return found[:3], found[3 : 3 + n], found[3 + n : last], found[last:]

    def rate(self, t, y, sense, motor):
        dw, dspeed, _, dv = self.accelerations(y, sense, motor)
        q, w = y[:4], y[4:7]
        dq = 0.5 * np.concatenate([[-q[1:] @ w], q[0] * w + np.cross(q[1:], w)])
        v = y[len(y) - len(dv) :]
        return np.concatenate([dq, dw, np.where(sense == 0.0, 0.0, dspeed), v, dv])

    def carry(self, y, motor, duration):
        """State after an interval of held motor torque."""
        y, t, released = np.array(y, float), 0.0, {}
        for _ in range(200):
            sense = np.sign(y[7 : 7 + len(self.D)])
            for k, s in released.items():
                sense[k] = s
            for _ in range(len(sense)):
                torque = self.accelerations(y, sense, motor)[2]
                excess = np.where(sense == 0.0, np.abs(torque) - self.static, -1.0)
                worst = int(np.argmax(excess))
                if excess[worst] <= 0.0:
                    break
                sense[worst] = np.sign(torque[worst])
            events = [self._event(k, sense, motor) for k in range(len(sense))]
            found = solve_ivp(
                self.rate, (t, duration), y, args=(sense, motor), events=events, **TIGHT
            )
            y, t = found.y[:, -1], found.t[-1]
            if found.status == 0:
                return y
            hit = next(k for k, times in enumerate(found.t_events) if len(times))
            released = {}
            if sense[hit] == 0.0:
                torque = self.accelerations(y, sense, motor)[2]
                released = {hit: np.sign(torque[hit])}
            else:
                y[7 + hit] = 0.0
        raise AssertionError("the reference needs more than 200 pieces")

    def _event(self, k, sense, motor):
        def turning(t, y, *_):
            return sense[k] * y[7 + k]

        def resting(t, y, *_):
            return self.static[k] - abs(self.accelerations(y, sense, motor)[2][k])

        event = resting if sense[k] == 0.0 else turning
        event.terminal, event.direction = True, -1.0
        return event
