"""Tables 2 and 3 of the paper, and its spacecraft, control laws and compensators."""

from typing import Any

import numpy as np

from gyrostat.control import (
    FirstOrderLags,
    Integrators,
    ModelErrorCompensator,
    OnlineFrit,
    OutputZeroing,
)
from gyrostat.core.jax64 import jnp
from gyrostat.spacecraft import SinusoidalMomentum, Spacecraft
from gyrostat.wheel import WheelArray

AXIS = (1.0, 2.0, 3.0)
ANGLE = np.deg2rad(30.0)
"""Initial rotation: axis in inertial space, and angle, rad."""
BODY = np.diag([4000.0, 5000.0, 6000.0])
WHEELS = np.diag([0.45, 0.225, 0.225]) + np.diag([0.225, 0.45, 0.225])
"""Sum of the wheel inertias, J_w1 + J_w2, kg·m²."""
ROTOR = 0.45
"""Inertia of a wheel about its axis, kg·m²."""
EXCESS = np.diag([20.003, 25.003, 30.002])
"""Inertia error J_t - J_tn, kg·m²."""
MOMENTUM, FREQUENCY = 0.05, 1e-4
"""Amplitude, N·m·s, and frequency, Hz, of the total momentum."""
PHASES = (0.0, 0.5 * np.pi, 0.0)
"""Phases of its sine, cosine and sine components, rad."""
FEEDBACK = 9e-4
"""Feedback gains F_1 and F_2, 1/s."""
FORGETTING, COVARIANCE, SMOOTHING, THRESHOLD = 0.995, 100.0, 0.45, 1.2e-4
"""Parameters of FRIT: lambda, P(0), kappa, psi."""
PERIOD, DURATION = 0.1, 10_000.0
"""Control period, and duration of a run (not printed: one period of the momentum), s."""
REQUIRED = 0.05
"""Required pointing accuracy, degrees."""


def spacecraft(total: np.ndarray, torque_limit: float = np.inf) -> Spacecraft:
    """Body with wheels along x and y.

    Args:
        total: Inertia with locked wheels J_t, (3, 3), kg·m².
        torque_limit: Torque limit of each wheel, N·m.
    """
    rotors = np.diag([ROTOR, ROTOR, 0.0])
    wheels = WheelArray(
        axes=jnp.eye(3)[:, :2], inertia=jnp.full(2, ROTOR), torque_limit=jnp.full(2, torque_limit)
    )
    return Spacecraft(inertia=jnp.asarray(total - rotors), wheels=wheels)


NOMINAL = BODY + WHEELS
ACTUAL = NOMINAL + EXCESS


def momentum(size: float = MOMENTUM, shift: float = 0.0) -> SinusoidalMomentum:
    """Total momentum H_0 of Table 2.

    Args:
        size: Amplitude of each component, N·m·s.
        shift: Angle added to every phase, rad.
    """
    return SinusoidalMomentum(
        amplitude=jnp.full(3, size), frequency=FREQUENCY, phase=jnp.asarray(PHASES) + shift
    )


def attitude(axis: tuple[float, ...] = AXIS) -> np.ndarray:
    """Initial quaternion, (4,), for a rotation axis of any length."""
    unit = np.asarray(axis) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(0.5 * ANGLE)], np.sin(0.5 * ANGLE) * unit])


def law(*, momentum_measured: bool = False) -> OutputZeroing:
    """Control law (9)-(12) with nominal inertia, with zero or with measured momentum."""
    return OutputZeroing(
        spacecraft=spacecraft(NOMINAL),
        feedback=jnp.full(2, FEEDBACK),
        momentum_measured=momentum_measured,
    )


def fixed(gain: float) -> ModelErrorCompensator:
    """Compensator (13), (14) with gain K = gain times the unit matrix, 1/s; 0: no compensation."""
    return ModelErrorCompensator(law(), Integrators(), gain * jnp.eye(2))


def tuned(**changes: Any) -> ModelErrorCompensator:
    """Compensator (13)-(30) with Table 3.

    Args:
        changes: Fields of `OnlineFrit` to change.
    """
    fields: dict[str, Any] = {
        "feedback": jnp.full(2, FEEDBACK),
        "reference": FirstOrderLags(jnp.full(2, FEEDBACK)),
        "forgetting": FORGETTING,
        "smoothing": SMOOTHING,
        "dead_zone": jnp.full(2, THRESHOLD),
        "initial_gain": jnp.zeros((2, 2)),
        "initial_covariance": COVARIANCE,
    }
    return ModelErrorCompensator(
        law(), Integrators(), jnp.zeros((2, 2)), OnlineFrit(**{**fields, **changes})
    )
