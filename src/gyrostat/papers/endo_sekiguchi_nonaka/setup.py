"""Tables 2 and 3, and the spacecraft, laws and compensators that they describe."""

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
"""Initial rotation axis, inertial, and angle, rad."""
BODY = np.diag([4000.0, 5000.0, 6000.0])
WHEELS = np.diag([0.45, 0.225, 0.225]) + np.diag([0.225, 0.45, 0.225])
"""J_w1 + J_w2, kg·m²."""
ROTOR = 0.45
"""Of a wheel about its axis, kg·m²."""
EXCESS = np.diag([20.003, 25.003, 30.002])
"""J_t - J_tn, kg·m²."""
MOMENTUM, FREQUENCY = 0.05, 1e-4
"""N·m·s and Hz."""
PHASES = (0.0, 0.5 * np.pi, 0.0)
"""Of sine, cosine and sine, rad."""
FEEDBACK = 9e-4
"""F_1 and F_2, 1/s."""
FORGETTING, COVARIANCE, SMOOTHING, THRESHOLD = 0.995, 100.0, 0.45, 1.2e-4
"""lambda, P(0), kappa, psi."""
PERIOD, DURATION = 0.1, 10_000.0
"""Of control, and of a run (not printed: one period of the momentum), s."""
REQUIRED = 0.05
"""Pointing accuracy that is wanted, degrees."""


def spacecraft(total: np.ndarray, torque_limit: float = np.inf) -> Spacecraft:
    """The body with wheels along x and y.

    Args:
        total: (3, 3) J_t, inertia with the wheels locked, kg·m².
        torque_limit: of each wheel, N·m.
    """
    rotors = np.diag([ROTOR, ROTOR, 0.0])
    wheels = WheelArray(
        axes=jnp.eye(3)[:, :2], inertia=jnp.full(2, ROTOR), torque_limit=jnp.full(2, torque_limit)
    )
    return Spacecraft(inertia=jnp.asarray(total - rotors), wheels=wheels)


NOMINAL = BODY + WHEELS
ACTUAL = NOMINAL + EXCESS


def momentum(size: float = MOMENTUM, shift: float = 0.0) -> SinusoidalMomentum:
    """H_0 of Table 2.

    Args:
        size: of each component, N·m·s.
        shift: added to every phase, rad.
    """
    return SinusoidalMomentum(
        amplitude=jnp.full(3, size), frequency=FREQUENCY, phase=jnp.asarray(PHASES) + shift
    )


def attitude(axis: tuple[float, ...] = AXIS) -> np.ndarray:
    """(4,) initial quaternion for a rotation axis of any length."""
    unit = np.asarray(axis) / np.linalg.norm(axis)
    return np.concatenate([[np.cos(0.5 * ANGLE)], np.sin(0.5 * ANGLE) * unit])


def law(*, momentum_measured: bool = False) -> OutputZeroing:
    """(9)-(12) with the nominal inertia and no momentum, or with that from what is measured."""
    return OutputZeroing(
        spacecraft=spacecraft(NOMINAL),
        feedback=jnp.full(2, FEEDBACK),
        momentum_measured=momentum_measured,
    )


def fixed(gain: float) -> ModelErrorCompensator:
    """(13), (14) with a gain K = gain times the unit matrix, 1/s; 0 is no compensator."""
    return ModelErrorCompensator(law(), Integrators(), gain * jnp.eye(2))


def tuned(**changes: Any) -> ModelErrorCompensator:
    """(13)-(30) with Table 3.

    Args:
        changes: fields of `OnlineFrit` that are to be others.
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
