"""Parameters printed in the paper, with its body and weights."""

from collections.abc import Iterable

import numpy as np

from gyrostat.core.jax64 import jnp
from gyrostat.core.rotations import EulerAngles
from gyrostat.papers.carvalho_fenili.torque_driven import TorqueDrivenBody
from gyrostat.spacecraft import Gyrostat, Spacecraft, WheelFailures
from gyrostat.wheel import WheelArray

MASS, EDGE = 200.0, 0.6
"""Table 1: mass, kg, and edge, m."""
INERTIA = MASS * EDGE**2 / 6.0
"""Inertia I of a cube, kg·m²."""
DURATION, STEP = 200.0, 0.01
"""Table 1: duration and step, s."""
FAILURE = 15.0
"""Time of the failure, s."""
ANGLES = EulerAngles(phi=0.7, theta=0.8, psi=0.6)
RATES = EulerAngles(phi=0.04, theta=0.04, psi=0.04)
"""Table 2: initial angles, rad, and rates, rad/s."""
STATE_WEIGHT = np.diag([50.0, 50.0, 10.0, 10.0, 10.0, 10.0])
"""Weight Q of (19), for the order theta, theta', phi, phi', psi, psi' of (14)."""
PRINTED_INPUT_WEIGHT = np.diag([50.0, 50.0, 100.0, 100.0, 100.0, 100.0])
"""Weight R of (20), for an input (0, M_x, 0, M_y, 0, M_z)."""
INPUT_WEIGHT = PRINTED_INPUT_WEIGHT[1::2, 1::2]
"""Part of R of (20) that has an effect: M_x 50, M_y 100, M_z 100."""

AXES = ("x", "y", "z")
ANGLE_NAMES = ("theta", "phi", "psi")
"""Angles of the three torques at theta = pi/2, psi = 0."""
LAWS = {"lqr": "LQR", "sdre": "SDRE"}
CASES: dict[str, tuple[int, ...]] = {
    "none": (),
    "Mx": (0,),
    "My": (1,),
    "Mz": (2,),
    "MxMy": (0, 1),
    "MxMz": (0, 2),
    "MyMz": (1, 2),
}
"""Axes whose torque fails, for each case."""
FAILING = tuple(case for case, failed in CASES.items() if failed)
FIGURES = {
    "Mx": (1, 13),
    "My": (3, 15),
    "Mz": (5, 17),
    "MxMy": (7, 19),
    "MxMz": (9, 21),
    "MyMz": (11, 23),
}
"""Number of the paper's figure of the angles, for LQR and SDRE; the next one shows the rates."""

HEALTHY = TorqueDrivenBody(INERTIA)
START = HEALTHY.start(ANGLES, RATES)
ROTOR = 0.01
"""Inertia of each rotor about its axis, chosen here, kg·m²: 3 N·m·s at 2900 rpm."""
TORQUE, MOMENTUM = 0.1, 3.0
"""Torque limit, N·m, and momentum limit, N·m·s, of each wheel, chosen here."""


def wheels_along_axes(torque: float = TORQUE, momentum: float = MOMENTUM) -> WheelArray:
    """Three wheels along the body axes with limits of torque, N·m, and momentum, N·m·s."""
    limits = jnp.full(3, torque), jnp.full(3, momentum)
    return WheelArray(jnp.eye(3), jnp.full(3, ROTOR), *limits)


def without_torques(spacecraft: Spacecraft, wheels: Iterable[int], time: float) -> Gyrostat:
    """Spacecraft of which some wheels lose their torque at a time, s."""
    failures = WheelFailures.none(3)
    for wheel in wheels:
        failures = failures.torque_lost(wheel, time)
    return Gyrostat(spacecraft, failures)


def failure_times() -> np.ndarray:
    """Time from which each torque is zero in each case, (7, 3), s; inf if it does not fail."""
    times = np.full((len(CASES), 3), np.inf)
    for row, failed in zip(times, CASES.values(), strict=True):
        row[list(failed)] = FAILURE
    return times


def failure_of(case: str) -> str:
    """Name of a case for figures."""
    names = [f"M{AXES[axis]}" for axis in CASES[case]]
    return "failure of " + " and ".join(names) if names else "no failure"
